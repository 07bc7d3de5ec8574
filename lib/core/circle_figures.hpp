#pragma once
/// Circles by ISO 230-4 and ISO 12181, and the shapes in them. How they are found: metrology/circle_iso.hpp,
/// metrology/signatures.hpp.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/estimate.hpp"
#include "core/spec.hpp"

namespace ballbar {

/// Why a figure is absent.
struct NotDefined {
  std::string figure;  ///< name of the field
  std::string reason;  ///< one sentence
  bool operator==(const NotDefined&) const = default;
};

/// Roundness about one of the reference circles (ISO 12181: RONt, RONp, RONv, RONq).
struct RoundnessAbout {
  double centre_x = 0.0;  ///< [m] from the ball, along the plane's first axis
  double centre_y = 0.0;  ///< [m] along normal x first axis
  double radius = 0.0;    ///< [m]; the middle of the zone for minimum zone
  double total = 0.0;     ///< [m] largest - smallest distance from the centre
  double peak = 0.0;      ///< [m] largest distance - radius
  double valley = 0.0;    ///< [m] radius - smallest distance
  double rms = 0.0;       ///< [m] root mean square of (distance - radius)
};

/// One direction.
struct CircleFigures {
  // the record
  int direction = 0;
  double nominal_radius = 0.0;            ///< [m]
  double feed = 0.0;                      ///< [m/s] programmed
  std::optional<double> calculated_feed;  ///< [m/s] mean over the arc
  Vec3 normal{};                          ///< of the plane, in the base frame
  Vec3 first_axis{};                      ///< angle 0
  double start_angle = 0.0;               ///< [rad] of the first sample
  double end_angle = 0.0;                 ///< [rad] of the last sample
  std::optional<double> filter_upr;       ///< cut-off of the Gaussian filter; nothing: not filtered
  std::int64_t samples = 0;               ///< that the figures are of
  std::optional<double> temperature;      ///< [degC]

  // the figures
  std::optional<double> circular_error_mz;   ///< [m] G, least radial separation of two concentric circles
  std::optional<double> circular_error_ls;   ///< [m] G about the least-squares centre
  double radial_max_setup = 0.0;             ///< [m] F max, about the set-up centre: the ball
  double radial_min_setup = 0.0;             ///< [m] F min, likewise
  std::optional<double> radial_max_ls;       ///< [m] F max, about the least-squares centre
  std::optional<double> radial_min_ls;       ///< [m] F min, likewise
  std::optional<Estimate> radius_deviation;  ///< [m] least-squares radius - nominal
  std::optional<Estimate>
      radius_20_deviation;          ///< [m] R20 - nominal, R20 the least-squares radius at 20 degC
  std::optional<double> expansion;  ///< [1/K] that R20 is made with
  std::optional<RoundnessAbout> lsc, mzc, mic, mcc;
  std::vector<NotDefined> not_defined;
};

/// Both directions of one repetition.
struct CirclePair {
  CircleFigures ccw, cw;
  std::optional<double> circular_error_b;     ///< [m] G(b), least radial separation that holds both paths
  std::optional<double> circular_error_b_ls;  ///< [m] the same about the common least-squares centre
  std::optional<Estimate> radial_error_d;     ///< [m] D, mean of both least-squares radii - nominal
  std::optional<double> hysteresis;           ///< [m] H (1996), largest difference of the radii at one angle
  double hysteresis_angle = 0.0;              ///< [rad] where
  double positional_tolerance = 0.0;          ///< [m] as join() of metrology/circle_iso.hpp defines it
  double radial_max_setup = 0.0;              ///< [m] F max of both
  double radial_min_setup = 0.0;              ///< [m] F min of both
  std::vector<NotDefined> not_defined;        ///< of the pair; those of one direction are there
};

struct Signature {
  std::string name;              ///< as in metrology/signatures.hpp
  std::optional<double> value;   ///< SI; nothing where the samples do not tell it apart
  std::optional<double> sd;      ///< SI
  double span = 0.0;             ///< [m] peak to peak of its part of the trace; 0 where not told apart
  double share = 0.0;            ///< span / circular error
  double without = 0.0;          ///< [m] circular error that the trace would have without it
  std::optional<double> detail;  ///< [m] travel s0 of a spike, pitch of a cyclic error
};

/// Signatures that these samples do not tell apart: only their sum is known.
struct SignatureGroup {
  std::vector<std::string> names;  ///< "centre_offset" may be among them
  double span = 0.0;               ///< [m] of the sum
  double share = 0.0;
};

struct SignatureFit {
  double frame_angle = 0.0;     ///< [rad] of X from the plane's first axis
  double circular_error = 0.0;  ///< [m] max - min of both directions about the common least-squares centre
  double residual =
      0.0;  ///< [m] standard deviation of what no signature explains, vibration and noise included
  std::vector<Signature> signatures;           ///< told apart, by falling share
  std::vector<SignatureGroup> not_told_apart;  ///< by falling share
  std::vector<NotDefined> not_defined;         ///< e.g. servo_mismatch where the feed is not known
};

}  // namespace ballbar

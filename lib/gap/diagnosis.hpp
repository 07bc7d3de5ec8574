#pragma once
/// What a diagnosis says (design.md 7). SI inside.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/estimate.hpp"
#include "core/spec.hpp"

namespace ballbar {

enum class Verdict { kNothingMissing, kExplained, kPartlyExplained, kUnknownEffect };

/// "nothing_missing", "explained", "partly_explained", "unknown_effect"
const char* to_string(Verdict verdict);

/// An effect that cannot be told from the one named, and what would decide.
struct Twin {
  std::string effect;
  int joint = 0;
  double resemblance = 0.0;  ///< 0 .. 1 of what the baseline leaves
  std::string label;         ///< Candidate::label(): which parameter or kind
  std::string to_tell_apart;
};

struct NamedParameter {
  std::string name;              ///< with unit
  double value = 0.0, sd = 0.0;  ///< in the unit of the name
};

struct LeftOut {
  EffectSpec spec;        ///< as a [[robot.effect]] table
  int level = 3;          ///< 1 joint zeros, 2 geometry, 3 everything else
  double share = 0.0;     ///< of the mismatch
  double evidence = 0.0;  ///< ln of the odds for it
  double size = 0.0;      ///< [m] root mean square of what the baseline cannot take up
  std::vector<NamedParameter> parameters;
  std::vector<Twin> twins;
  std::string driver;  ///< not_in_catalogue: "angle", "velocity", "direction", "torque" or "time"
  std::string says;
};

/// A place where model and recording part.
struct Located {
  int joint = 0;
  std::string what, test;
  int direction = 0;
  TestKind kind = TestKind::kCircle;
  char axis = ' ';              ///< lines: direction of the deviation
  double from = 0.0, to = 0.0;  ///< [rad] of the arc; [m] of the line, from its start
  double size = 0.0;            ///< [m]
  std::string grows_with;
  std::string says;
};

struct FitFigures {
  std::vector<std::string> runs;
  double before = 0.0, after = 0.0;  ///< [m] root mean square
  double floor = 0.0;                ///< [m] of noise alone
  double expected = 0.0;  ///< [m] of noise and, where this was not fitted, the uncertainty of what was
};

struct Nuisance {
  std::string name;  ///< with unit
  double value = 0.0, sd = 0.0;
};

struct Remainder {
  double rms = 0.0;  ///< [m]
  double worst_z = 0.0;
  std::string structure = "none";
  int joint = 0;
};

/// The mean of an observation's laps at its places, and what the model predicts there. What the set-up leaves
/// open of `after` is taken off all three, for it is no gap: of a circle mean and order 1, of a line offset
/// and slope.
struct FitTrace {
  std::vector<std::string> runs;
  std::string test, series;
  int direction = 0;
  bool held_out = false;
  double feed = 0.0;     ///< [m/s]
  double payload = 0.0;  ///< [kg]
  TestKind kind = TestKind::kCircle;
  char axis = ' ';                ///< lines: direction of the deviation
  Eigen::VectorXd place;          ///< [rad] of a circle, [m] from the start of a line
  Eigen::VectorXd measured;       ///< [m]
  Eigen::VectorXd before, after;  ///< [m] predicted: as configured, with what was found
};

struct Diagnosis {
  Verdict verdict = Verdict::kNothingMissing;
  double noise_floor = 0.0;  ///< [m] of the mean of an observation's laps
  bool noise_from_repeats = false;
  FitFigures fit, held_out;
  bool circles = true, lines = false;  ///< what was fitted
  bool holds_elsewhere =
      true;  ///< observations that were not fitted are not missed by far more than expected
  bool held_out_by_leaving_out = false;  ///< nothing was held out: each pair left out in turn
  std::vector<Located> located;
  std::vector<LeftOut> left_out;
  std::vector<NamedParameter> zero_offsets;  ///< as fitted, one per joint, material or not [deg]
  std::vector<NamedParameter> mastering;     ///< the same in the controller's joint convention [deg]
  std::vector<Nuisance> nuisance;
  Remainder remainder;
  std::vector<FitTrace> traces;       ///< for pictures
  std::vector<std::string> warnings;  ///< what the data do not carry, in sentences
};

}  // namespace ballbar

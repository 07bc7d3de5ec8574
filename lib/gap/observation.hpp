#pragma once
/// Circles and lines, made ready for a diagnosis: laps that repeat each other are one observation.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/run.hpp"
#include "core/spec.hpp"
#include "gap/instrument.hpp"
#include "kinematics/robot_model.hpp"
#include "numerics/noise_spectrum.hpp"
#include "numerics/whitening.hpp"
#include "physics/motion.hpp"

namespace ballbar {

/// Places on a turn at which a model is worked out, and the highest harmonic that is looked at
/// (physics-gap.md 5: step 1).
inline constexpr double kPlacesPerTurn = 400.0;
inline constexpr double kHighestFrequency = 180.0;  ///< [cycles per turn]

/// How the names of series end that are not fitted but used as proof.
inline constexpr const char* kHeldOutEnding = "-held-out";

/// A run with its instrument's readings and joints; of a circle, where its measured arc was found: members as
/// in RunResult.
struct MeasuredRun {
  Run run;
  std::vector<double> angle;
  std::size_t arc_begin = 0;
  std::size_t arc_end = 0;
};

/// All laps of one test in one direction that follow each other under the same conditions; of a line, as read
/// in one direction of deviation. The whole line counts as a turn: frequencies are cycles on it.
struct Observation {
  std::vector<std::string> runs;  ///< names of the laps, as shown
  std::string test, series;
  int direction = 0;
  double feed = 0.0;          ///< [m/s]
  Instrument instrument;      ///< and where it stands
  int set_up = 0;             ///< observations with the same number share one set-up
  Conditions conditions;      ///< series_time: mean of the laps' begins
  std::int64_t begin_us = 0;  ///< of the first lap
  std::int64_t end_us = 0;    ///< of the last lap
  Motion said;                ///< the joints' own samples, angles of the chain, of the first lap
  Eigen::VectorXd time;       ///< [s] at which the model is worked out: overshoot, arc, a little behind it
  std::vector<Eigen::Index> sample;  ///< of time, rising: one for each place
  Eigen::VectorXd place;  ///< [rad] commanded angle of a circle, [m] from a line's start; in the middles of
                          ///< equal parts of the way, or where the robot stood
  bool at_rest = false;   ///< the robot stood at each place
  CosineTransform transform{1, 1.0, 0.0};
  Eigen::VectorXd measured;        ///< [m] coefficients of the mean of the laps
  Eigen::MatrixXd laps;            ///< [m] coefficients, a lap per column
  double readings_per_turn = 0.0;  ///< or on the line
  Eigen::VectorXd variance;        ///< [m^2] of the noise in `measured`; by assign_noise()

  Eigen::Index places() const { return place.size(); }
};

struct Observations {
  std::vector<Observation> all;
  std::vector<std::string> left_aside;  ///< one sentence for each run that could not be used
};

/// In sequence of their begins. A lap joins an earlier one of the same series, test, direction, payload and
/// feed where at most ten minutes and no other test lie between them, and nothing has moved.
/// @param runs  of this robot, of configured tests: circles of a bar, lines of straightness optics
Observations observe(std::vector<MeasuredRun> runs, const RobotSpec& robot, const RobotModel& model);

struct NoiseLevel {
  bool from_repeats = false;  ///< else from single laps, which know nothing of what is slow
  double floor = 0.0;         ///< [m] root mean square of the noise in the observations' means
  double lap = 0.0;           ///< [m] of a single lap
};

/// As if all places were equally noisy, 1 um, and a line had as many as a turn: what is then whitened is in
/// micrometres, and an effect that shows on a line counts as one that shows on a circle.
/// @return places that the observation counts for
double even_out(Observation& seen);

/// Fits the noise to the scatter of the laps, separately for bars and optics, and for like densities of
/// readings, and writes Observation::variance (of the mean of the laps).
NoiseLevel assign_noise(std::vector<Observation>& observations);

}  // namespace ballbar

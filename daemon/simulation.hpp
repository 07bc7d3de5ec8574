#pragma once
/// Simulated runs as figures and pictures, for `ballbar simulate`.

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bus/assembler.hpp"
#include "daemon/json_out.hpp"
#include "gap/simulate.hpp"
#include "pipeline/process.hpp"
#include "report/motion_plot.hpp"

namespace ballbar {

/// The whole text as one finite number, or nothing.
std::optional<double> finite_number(const std::string& text);

/// "joint_zero_offset,joint=3,offset_deg=0.172": numbers become parameters, everything else words.
/// @throws Error(kInput) where the text has another form; names are the catalogue's business
EffectSpec parse_effect(const std::string& text);

Json effects_json(const std::vector<EffectSpec>& effects);

/// Simulated samples through the same path as live data.
class Simulation {
 public:
  /// @param known  what the daemon knows of the robot: the simulated one may hold more
  Simulation(const RobotSpec& robot, const AsBuilt& known);

  /// The run as `show --json` gives it, without an id; for circles also ball_mm, centre_shift_mm (ball -
  /// programmed centre), p2p_um (max - min of the bar) and bar_harmonics (orders 0..10 of the bar's deviation
  /// over the commanded angle, least squares on the measured arc: on a full turn plain Fourier coefficients).
  Json analyse(const SimulatedRun& simulated);

  /// Only whether the run is ok: the same status and message at a small part of the time.
  RunResult judge(const SimulatedRun& simulated);

 private:
  const RobotSpec& robot_;
  const AsBuilt& known_;
  Assembler assembler_;
  std::map<std::pair<std::string, int>, Partners> partners_;  ///< by test and direction
  std::map<std::string, int> repetition_;                     ///< the latest, by test
};

/// A line per circle, and per axis of a line.
void print_simulation(const Json& runs);

/// Traces as the bar or the interferometer sees them, and the joints' motion of the first test.
class SimulationPlot {
 public:
  SimulationPlot(const RobotSpec& robot, const RobotModel& model) : robot_(robot), model_(model) {}

  /// Of a line its first repetition, for both axes go into one picture.
  /// @throws Error(kInput) where circles and lines are mixed
  void add(const SimulatedRun& simulated);

  /// Where the joints' motion goes. @throws Error(kInput) for another ending than .svg and .png
  static std::string joints_path(const std::string& path);

  /// Writes `path`, and the joints' motion beside it with "-joints" before the ending.
  void render(const std::string& path, const std::string& series) const;

 private:
  void add_motion(const SimulatedRun& simulated);

  const RobotSpec& robot_;
  const RobotModel& model_;
  PolarPlot polar_;
  LinePlot line_;
  MotionPlot motion_;  ///< of the first test
  std::string tests_;
};

}  // namespace ballbar

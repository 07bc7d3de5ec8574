#pragma once
/// One finished recording of one circle or line, as assembled from the streams.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/spec.hpp"

namespace ballbar {

/// How a run came to its end.
enum class RunEnd {
  kMark,             ///< by its end mark
  kAborted,          ///< by an abort mark: discarded, a row says so
  kSilence,          ///< nothing was heard any more
  kNextBegin,        ///< the next run began without an end mark of this one
  kProducerRestart,  ///< seq and time of a stream fell back
  kInterrupted,      ///< the service was stopped while it ran
  kTooLong,          ///< more samples than the stated maximum
  kMarksLost,        ///< a mark was lost, or the end mark is another run's: where it ended is not known
  kNoBegin,          ///< an end mark came whose begin mark was lost: a row says so
  kGeometry,         ///< no marks: recognised by the circle that the joints drove, which was over
};

/// Runs that are discarded: a row says so, no figures are made.
inline bool discards(RunEnd end) {
  return end == RunEnd::kAborted || end == RunEnd::kProducerRestart || end == RunEnd::kNoBegin;
}

struct InterferometerReading {
  char axis = 'X';
  double time = 0.0;       ///< [s] since the begin of the run
  double position = 0.0;   ///< [m] along the line, from its start
  double deviation = 0.0;  ///< [m]
};

/// A run is identified by its robot and the time of its begin; test, direction, repetition and series are
/// labels.
struct Run {
  std::string robot;
  std::string test;
  TestKind kind = TestKind::kCircle;
  int direction = 0;  ///< +1 counter-clockwise / forward, -1 clockwise / backward, 0 not known
  int repetition = 0;
  std::string series;
  std::int64_t started_us = 0;  ///< producer's clock, of the begin mark
  std::int64_t ended_us = 0;    ///< producer's clock, of the end mark or of the last sample
  RunEnd end = RunEnd::kMark;

  double feed = 0.0;                  ///< [m/s]
  double payload = 0.0;               ///< [kg]
  std::optional<double> temperature;  ///< [degC]

  std::vector<double> bar_time;       ///< [s] since the begin; rising
  std::vector<double> bar_deviation;  ///< [m] one per bar_time
  bool virtual_bar = false;           ///< the readings are the joints' (virtual ballbar), no instrument's

  int joints = 0;
  std::vector<double> joint_time;      ///< [s] since the begin; rising
  std::vector<double> joint_position;  ///< [rad] row-major, joint_time.size() x joints, as on the wire
  std::vector<double> joint_torque;    ///< [Nm] empty, or as joint_position

  std::vector<InterferometerReading> readings;

  std::int64_t lost_messages = 0;  ///< missing seq of all streams while the run was open
  int receiver_restarts = 0;       ///< holes of unknown size: the receive path died and was started again
};

/// Test, signed direction, repetition: "A+1#2".
inline std::string run_name(const std::string& test, int direction, int repetition) {
  return test + (direction > 0 ? "+1" : direction < 0 ? "-1" : "+0") + "#" + std::to_string(repetition);
}
inline std::string run_name(const Run& run) { return run_name(run.test, run.direction, run.repetition); }

}  // namespace ballbar

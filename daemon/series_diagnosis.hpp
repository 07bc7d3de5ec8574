#pragma once
/// The diagnosis of stored circles and lines, by the tool and, at the end of a series, by a process of its
/// own beside the service.

#include <string>
#include <vector>

#include "core/gap_record.hpp"
#include "gap/diagnosis.hpp"
#include "gap/observation.hpp"
#include "physics/as_built.hpp"
#include "store/store.hpp"

namespace ballbar {

/// Circles of the bar whose angles come from joints; lines whose joints were recorded too.
bool can_be_diagnosed(const StoredRun& run);

MeasuredRun measured_run(const Store& store, const StoredRun& run);

/// [us] Circles of one series that lie further apart are two measurements: the name was used again.
inline constexpr std::int64_t kSameMeasurementUs = 12LL * 3'600'000'000;

/// A robot that never rests has no end of a measurement.
inline constexpr std::size_t kMostRunsOfMeasurement = 500;

/// The last measurement of this robot under this name: circles and lines of the series and of the one that
/// ends in "-held-out", back to where nothing was heard for so long, and at most so many. Oldest first,
/// without their figures.
std::vector<StoredRun> latest_measurement(const Store& store, const std::string& robot,
                                          const std::string& series,
                                          std::int64_t apart_us = kSameMeasurementUs,
                                          std::size_t most = kMostRunsOfMeasurement);

/// Observations split into those that are fitted and those that are held out, with their noise.
struct DiagnosisInput {
  std::vector<Observation> fitted, held_out;
  NoiseLevel noise;
  std::vector<std::string> left_aside;  ///< one sentence for each run that could not be used
};

/// @param hold_out  tests that are not fitted, beside series whose names end in "-held-out"
/// @throws Error(kInput) where nothing is left to be fitted
DiagnosisInput diagnosis_input(std::vector<MeasuredRun> runs, const RobotSpec& robot, const AsBuilt& built,
                               const std::vector<std::string>& hold_out);

/// Its first figures, for rules and listeners. @param ended_us of the last run
GapRecord gap_record(const Diagnosis& diagnosis, const std::string& robot, const std::string& series,
                     std::int64_t ended_us);

/// The same of what the process has printed. @throws Error(kWorld) where that is not whole
StoredGap gap_from_text(const std::string& text);

/// The paragraph of a diagnosis; "" where there is none.
std::string says_of(const StoredGap& gap);

/// Main of the process: reads configuration and database, writes the diagnosis of the latest measurement as
/// one JSON object to standard output, or one line to standard error. As nice as can be, ended when its
/// parent is.
/// @param words  configuration, database, robot, series
/// @return exit code
int run_series_diagnosis(const std::vector<std::string>& words);

}  // namespace ballbar

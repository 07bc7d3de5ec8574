#pragma once
/// Keeping house: retention, backup, check, restore, recovery of what is damaged.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "store/store.hpp"

namespace ballbar {

/// 0: no limit.
struct RetentionLimits {
  std::int64_t keep_us = 0;         ///< runs, diagnoses and alarm events older than this go
  std::int64_t keep_traces_us = 0;  ///< likewise recordings
  std::int64_t max_bytes =
      0;  ///< of data; where there are more, the oldest recordings go, then the oldest runs and what is older
};

struct Removed {
  std::int64_t traces = 0, runs = 0, diagnoses = 0, events = 0;
  bool none() const { return traces + runs + diagnoses + events == 0; }
  Removed& operator+=(const Removed& more) {
    traces += more.traces;
    runs += more.runs;
    diagnoses += more.diagnoses;
    events += more.events;
    return *this;
  }
};

/// Deletes what is too old or too much, recordings before results. Age counts back from the robot's newest
/// run, or from now where that lies in the future: a producer's wrong clock deletes nothing.
class Retention {
 public:
  /// One small transaction, of at most `most` recordings: a run that ends meanwhile waits some milliseconds.
  /// To be called again and again; one that removed nothing may not yet have looked at all.
  /// @param now_us  the daemon's clock
  Removed step(Store& store, const RetentionLimits& limits, std::int64_t now_us, int most = 20);

 private:
  std::map<std::string, std::int64_t> cleared_us_;  // by robot: recordings of runs up to this begin are gone
};

/// Pages in use, in bytes: without the room that deleted rows left, which new ones take.
std::int64_t data_bytes(Store& store);

/// Copies a database, also while another process writes to it, into one tidy and checked file.
/// @throws StoreError where it cannot, or where there is a file at `to`; then nothing is changed
void backup(const std::string& from, const std::string& to);

/// What is wrong with a database, one line each; empty where it is sound. Every page, reference and recording
/// is read. @throws StoreError where it cannot be opened
std::vector<std::string> damages(const std::string& path);

/// Puts a checked copy of a backup in the place of a database that nobody has open. The one that was there
/// is set aside.
/// @return its new path; empty where there was none. @throws StoreError where the backup is damaged or none
/// of ours
std::string restore(const std::string& backup_path, const std::string& path);

struct Recovered {
  std::int64_t runs = 0;    ///< written
  std::int64_t traces = 0;  ///< of these with their recording
  std::int64_t lost = 0;    ///< runs, or parts of one (its figures, its recording), that could not be read
};

/// Reads what can still be read of a damaged database into another one, run by run; runs that are there
/// already stay as they are. The damaged one is not changed.
/// @throws StoreError where nothing of it can be read, or where `into` cannot be written
Recovered recover(const std::string& damaged, Store& into);

}  // namespace ballbar

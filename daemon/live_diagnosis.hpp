#pragma once
/// Series are diagnosed when they end, each in a process of its own: this program again, one at a time, at
/// the lowest priority. Whatever becomes of it, the service goes on; its result is stored and published like
/// a run's.

#include <cstdint>
#include <functional>
#include <string>

#include "daemon/child_output.hpp"
#include "daemon/log.hpp"
#include "daemon/series_watch.hpp"
#include "daemon/service.hpp"

namespace ballbar {

class LiveDiagnosis {
 public:
  /// @param program  path of this program; `service` and `store` must outlive it
  LiveDiagnosis(std::string program, Service& service, const Store& store, Service::Log log);

  /// Takes up what was heard before this start: the last series of each robot that has no diagnosis.
  void take_up(std::int64_t now_us);

  void heard(const Run& run, const RunResult& result, std::int64_t now_us);

  /// Starts what is due, takes what has ended. Never waits. @param now_us  steady clock
  void tick(std::int64_t now_us);

  /// Ends a diagnosis that runs: it is taken up at the next start.
  void stop();

 private:
  std::int64_t silence_us() const;
  void start(const EndedSeries& ended, std::int64_t now_us);
  void take(const ChildOutput::Ended& ended);

  std::string program_;
  Service& service_;
  const Store& store_;
  Service::Log log_;
  SeriesWatch watch_;
  ChildOutput child_;
  EndedSeries at_work_;
  std::int64_t started_us_ = 0;
};

}  // namespace ballbar

#include "daemon/live_diagnosis.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "daemon/series_diagnosis.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kMostUs = 600'000'000;  // for one diagnosis: then something is wrong with it
constexpr std::int64_t kLooksBack = 100;       // runs, for the last one that a diagnosis can use

}  // namespace

LiveDiagnosis::LiveDiagnosis(std::string program, Service& service, const Store& store, Service::Log log)
    : program_(std::move(program)), service_(service), store_(store), log_(std::move(log)), watch_(0) {
  watch_.configure(silence_us());
}

std::int64_t LiveDiagnosis::silence_us() const {
  return std::llround(1e6 * service_.config().series_ends_after);
}

void LiveDiagnosis::take_up(std::int64_t now_us) {
  if (!service_.config().live_diagnosis) return;
  for (const RobotSpec& robot : service_.config().robots) {
    RunFilter last;
    last.robot = robot.name;
    last.status = "ok";
    last.newest_first = true;
    last.limit = kLooksBack;
    last.labels_only = true;
    const std::vector<StoredRun> found = store_.runs(last);
    const auto latest = std::find_if(found.begin(), found.end(), can_be_diagnosed);
    if (latest == found.end()) continue;
    const std::string series = base_series(latest->series);
    const std::vector<StoredRun> runs = latest_measurement(store_, robot.name, series);
    for (const StoredRun& run : runs) watch_.heard(robot, run.series, run.test, run.direction, now_us);
    GapFilter known;
    known.robot = robot.name;
    known.series = series;
    known.limit = 1;
    const std::vector<StoredGap> gaps = store_.gaps(known);
    if (!runs.empty() && !gaps.empty() && gaps.front().record.ended_us >= runs.back().ended_us)
      watch_.diagnosed(robot.name);
  }
}

void LiveDiagnosis::heard(const Run& run, const RunResult& result, std::int64_t now_us) {
  const RobotSpec* robot = service_.config().find_robot(run.robot);
  const bool line = run.kind == TestKind::kLine;
  if (!robot || !robot->find_test(run.test) || result.status != "ok" ||
      result.source != (line ? "interferometer" : "bar") ||
      (line ? result.predicted_from : result.angle_source) != "joints")
    return;
  watch_.heard(*robot, run.series, run.test, run.direction, now_us);
}

void LiveDiagnosis::tick(std::int64_t now_us) {
  watch_.configure(silence_us());
  if (child_.running()) {
    if (const auto ended = child_.poll()) {
      take(*ended);
    } else if (now_us - started_us_ > kMostUs) {
      child_.kill();
      log_(Priority::kError, "the diagnosis of series '" + at_work_.series + "' of " + at_work_.robot +
                                 " took too long and was ended");
    }
    return;
  }
  const std::optional<EndedSeries> ended = watch_.next(now_us);
  if (ended && service_.config().live_diagnosis) start(*ended, now_us);
}

void LiveDiagnosis::start(const EndedSeries& ended, std::int64_t now_us) {
  at_work_ = ended;
  started_us_ = now_us;
  try {
    child_.start({program_, "--diagnose", service_.config().path, store_.path(), ended.robot, ended.series});
    log_(Priority::kInfo,
         ended.robot + " series '" + ended.series + "' is over (" + ended.why + ") and is diagnosed");
  } catch (const Error& error) {
    log_(Priority::kError, "series '" + ended.series + "' is not diagnosed: " + error.what());
  }
}

void LiveDiagnosis::take(const ChildOutput::Ended& ended) {
  const std::string whose = at_work_.robot + " series '" + at_work_.series + "'";
  if (ended.code != 0)
    return log_(Priority::kWarning,
                whose + " is not diagnosed: " +
                    (ended.err.empty() ? "its process ended with " + std::to_string(ended.code) : ended.err));
  try {
    service_.on_gap(gap_from_text(ended.out));
  } catch (const Error& error) {
    log_(Priority::kError, whose + ": " + error.what());
  }
}

void LiveDiagnosis::stop() { child_.kill(); }

}  // namespace ballbar

#include "daemon/service.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "core/error.hpp"
#include "daemon/clock.hpp"
#include "daemon/series_diagnosis.hpp"
#include "daemon/tool.hpp"
#include "pipeline/catalogue.hpp"
#include "pipeline/circle_test.hpp"
#include "pipeline/process.hpp"
#include "pipeline/recognition.hpp"
#include "pipeline/virtual_bar.hpp"
#include "rules/subjects.hpp"

namespace ballbar {
namespace {

constexpr std::size_t kMaxWaiting = 500;     // runs in memory while the database cannot be written,
constexpr std::size_t kMaxWaitingGaps = 20;  // diagnoses likewise
constexpr std::size_t kMaxWaitingCalibrations = 100;
constexpr std::size_t kMaxWaitingBytes = std::size_t{128} << 20;  // and their samples

std::string short_um(const Record& record, const char* name) {
  const auto found = record.values.find(name);
  if (found == record.values.end()) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.1f um", found->second.value);
  return text;
}

/// One line for the journal.
std::string summary(const Run& run, const RunResult& result, const Record& record) {
  std::string line = run.robot + " " + run_name(run.test, run.direction, run.repetition);
  if (!run.series.empty()) line += " (" + run.series + ")";
  if (run.end == RunEnd::kGeometry) line += ", without marks";
  line += ": " + result.status;
  if (run.virtual_bar) line += ", virtual ballbar";
  if (result.circle)
    line += ", ovality " + short_um(record, "ovality_um") + ", circular deviation " +
            short_um(record, "circular_deviation_um");
  if (result.circle_test)
    line += ", with the other direction: circular error " +
            short_um(record, "circular_error_bidirectional_um") + ", hysteresis " +
            short_um(record, "hysteresis_um");
  if (!record.axis.empty())
    line += ", straightness " + record.axis + " " + short_um(record, "straightness_mz_um");
  line += ", " + std::to_string(result.samples) + " samples, " + std::to_string(run.lost_messages) +
          " messages lost";
  if (run.receiver_restarts > 0)
    line += ", " + std::to_string(run.receiver_restarts) + " holes by a dead receiver";
  if (!result.message.empty()) line += ": " + result.message;
  return line;
}

bool cut_short(RunEnd end) {
  return end == RunEnd::kInterrupted || end == RunEnd::kSilence || end == RunEnd::kNextBegin ||
         end == RunEnd::kTooLong;
}

}  // namespace

Models load_models(const Config& config) {
  Models models;
  for (const RobotSpec& robot : config.robots) {
    try {
      RobotModel model(read_text(robot.urdf_path), robot.base, robot.tip, robot.joint_convention);
      const auto joints = static_cast<std::size_t>(model.joints());
      if (!robot.gear_ratio.empty() && robot.gear_ratio.size() != joints)
        throw Error(Cause::kInput, "'gear_ratio' holds " + std::to_string(robot.gear_ratio.size()) +
                                       " numbers, the chain has " + std::to_string(joints) + " joints");
      models.emplace(robot.name, AsBuilt(model, robot));
    } catch (const Error& error) {
      throw Error(error.cause(),
                  config.path + ": robot '" + robot.name + "': " + robot.urdf_path + ": " + error.what());
    }
  }
  return models;
}

MakeRecogniser recogniser_of(const Models& models) {
  return [&models](const RobotSpec& robot) -> std::unique_ptr<Recogniser> {
    const auto model = models.find(robot.name);
    return model == models.end() ? nullptr : make_recogniser(robot, model->second.model());
  };
}

LoadReport load_rules(const Config& config, const RuleSet* last_good) {
  try {
    return RuleSet::load_folders(config.rule_folders(), last_good);
  } catch (const Error& error) {
    LoadReport report;
    if (last_good) report.rules = *last_good;
    report.errors.push_back({"", "no rules", 0, error.what()});
    return report;
  }
}

Service::Service(Config config, Models models, RuleSet rules, Store& store, Log log)
    : config_(std::move(config)),
      models_(std::move(models)),
      rules_(std::move(rules)),
      store_(store),
      log_(std::move(log)),
      alarms_(store, log_, [this](const AlarmStatus& alarm) {
        if (publisher_) publisher_->publish(alarm);
      }) {}

void Service::on_run(Run run) {
  enqueue(std::move(run));
  retry();
}

void Service::enqueue(Run run) {
  waiting_.push_back(std::move(run));
  while (waiting_.size() > kMaxWaiting || waiting_bytes() > kMaxWaitingBytes) {
    log_(Priority::kError, "too many runs wait for the database: the oldest is lost");
    waiting_.pop_front();
  }
}

void Service::on_gap(StoredGap gap) {
  waiting_gaps_.push_back(std::move(gap));
  retry_gaps();
  if (waiting_gaps_.size() <= kMaxWaitingGaps) return;
  log_(Priority::kError, "too many diagnoses wait for the database: the oldest is lost");
  waiting_gaps_.pop_front();
}

void Service::on_calibration(BaselineMark mark) {
  waiting_calibrations_.push_back(std::move(mark));
  if (waiting_calibrations_.size() <= kMaxWaitingCalibrations) return;
  log_(Priority::kError, "too many calibrations wait for the database: the oldest is lost");
  waiting_calibrations_.pop_front();
}

/// @return false where some wait on
bool Service::retry_calibrations(std::uint64_t until_us) {
  while (!waiting_calibrations_.empty()) {
    if (steady_us() >= until_us) return false;
    const BaselineMark& mark = waiting_calibrations_.front();
    try {
      store_.set_baseline(mark);
    } catch (const StoreError& error) {
      ++counters_.store_failures;
      const std::string said =
          std::string("calibrations wait in memory and are tried again: ") + error.what();
      if (said != said_) log_(Priority::kError, said);
      said_ = said;
      return false;
    }
    log_(Priority::kNotice, mark.robot + (mark.test.empty() ? ", all tests" : ", test " + mark.test) +
                                ": calibrated at " + utc_text(mark.at_us) + " UTC, a new baseline begins" +
                                (mark.note.empty() ? "" : ": " + mark.note));
    waiting_calibrations_.pop_front();
  }
  return true;
}

void Service::retry_gaps() {
  while (!waiting_gaps_.empty()) {
    const StoredGap& gap = waiting_gaps_.front();
    try {
      store_.save_gap(gap);
      ++counters_.diagnoses;
      tell(gap);
      judge(gap.record);
    } catch (const StoreError& error) {
      ++counters_.store_failures;
      const std::string said = std::string("diagnoses wait in memory and are tried again: ") + error.what();
      if (said != said_gaps_) log_(Priority::kError, said);
      said_gaps_ = said;
      return;
    } catch (const std::invalid_argument& error) {
      log_(Priority::kError, "diagnosis of series '" + gap.record.series + "' not stored: " + error.what());
    }
    waiting_gaps_.pop_front();
    said_gaps_.clear();
  }
}

void Service::tell(const StoredGap& gap) {
  const std::string says = says_of(gap);
  const GapRecord& record = gap.record;
  log_(record.verdict == "nothing_missing" || record.verdict == "explained" ? Priority::kNotice
                                                                            : Priority::kWarning,
       record.robot + " series '" + record.series + "': " + record.verdict + ": " + says);
  if (publisher_) publisher_->publish(record, says);
}

std::string Service::unstored() const {
  std::string all;
  const auto add = [&all](std::size_t number, const char* one, const char* more) {
    if (number > 0)
      all += (all.empty() ? "" : ", ") + std::to_string(number) + " " + (number == 1 ? one : more);
  };
  add(waiting_.size(), "run", "runs");
  add(waiting_calibrations_.size(), "calibration", "calibrations");
  add(waiting_gaps_.size(), "diagnosis", "diagnoses");
  add(alarms_.unsaved(), "change of alarms", "changes of alarms");
  return all;
}

void Service::retry(std::uint64_t most_us) {
  const std::uint64_t now_us = steady_us();
  const std::uint64_t until_us = most_us > UINT64_MAX - now_us ? UINT64_MAX : now_us + most_us;
  alarms_.retry();
  if (!retry_calibrations(until_us)) return;
  if (!waiting_gaps_.empty()) retry_gaps();
  while (!waiting_.empty()) {
    Run& run = waiting_.front();
    try {
      take(run);
    } catch (const StoreError& error) {
      ++counters_.store_failures;
      store_damaged_ = error.kind() == StoreFault::kCorrupt || error.kind() == StoreFault::kNotADatabase;
      const std::string said =
          std::to_string(waiting_.size()) + " runs wait in memory and are tried again: " + error.what();
      if (said != said_) log_(Priority::kError, said);  // not every five seconds of a night
      said_ = said;
      return;
    } catch (const std::invalid_argument& error) {  // a bug of ours, and no reason to try again
      log_(Priority::kError, run.robot + " " + run_name(run.test, run.direction, run.repetition) +
                                 " not stored: " + error.what());
    }
    waiting_.pop_front();
    store_can_be_written();
    if (steady_us() >= until_us) return;
  }
  store_can_be_written();
}

void Service::store_can_be_written() {
  store_damaged_ = false;
  if (!said_.empty()) log_(Priority::kNotice, "the database can be written again");
  said_.clear();
}

std::size_t Service::waiting_bytes() const {
  std::size_t numbers = 0;
  for (const Run& run : waiting_)
    numbers += 2 * run.bar_time.size() + run.joint_time.size() + run.joint_position.size() +
               run.joint_torque.size() + 4 * run.readings.size();
  return numbers * sizeof(double);
}

/// The whole way of one run; a StoreError leaves everything as it was.
void Service::take(Run& run) {
  // What was cut short is replaced where the whole run comes later, e.g. from a log.
  const std::optional<RunEnd> stored = store_.end_of(run.robot, run.started_us);
  const bool repairs = stored && cut_short(*stored) && run.end == RunEnd::kMark;
  if (stored && !repairs) {
    ++counters_.runs_known;
    return log_(Priority::kInfo,
                run.robot + " " + run_name(run.test, run.direction, run.repetition) + ": already stored");
  }
  const RunResult result = analyse(run);
  if (run.direction == 0) run.direction = result.direction;
  const std::vector<Record> found = records(run, result);
  Judged judged = judge(run, result, found);
  alarms_.number(judged.states, judged.events);
  store_.save(run, result, found, judged.states, judged.events, repairs);
  if (result.status == "ok") note_last(run.robot, run.test, run.ended_us);
  ++counters_.runs_stored;
  if (result.status == "ok") ++counters_.runs_ok;
  tell(run, result, found, judged);
  if (stored_) stored_(run, result);
}

RunResult Service::analyse(Run& run) const {
  const RobotSpec* robot = config_.find_robot(run.robot);
  const TestSpec* test = robot ? robot->find_test(run.test) : nullptr;
  if (!test || test->kind != run.kind) {
    RunResult result;
    result.status = "failed";
    result.message = "the test was taken out of the configuration while it ran";
    return result;
  }
  const auto model = models_.find(run.robot);
  const AsBuilt* known = model == models_.end() ? nullptr : &model->second;
  try {
    if (known) add_virtual_bar(run, *test, known->model());
    return process(run, *test, known, partners_of(run));
  } catch (const StoreError&) {
    throw;
  } catch (const std::exception& error) {  // a run always gives one row, also when its analysis threw
    RunResult result;
    result.status = "failed";
    result.message = error.what();
    return result;
  }
}

Partners Service::partners_of(const Run& run) const {
  Partners partners;
  if (run.kind == TestKind::kLine) {
    for (auto& [axis, points] :
         store_.line_partner(run.robot, run.test, run.series, run.direction, run.repetition, run.started_us))
      partners.lines.push_back({axis, std::move(points)});
  } else if (const auto other = store_.circle_partner(run, run.virtual_bar ? kVirtualSource : "bar")) {
    const Trace& trace = other->trace;
    partners.circle = measured_arc(trace.angle, trace.bar_deviation, trace.arc_begin, trace.arc_end);
    partners.circle->direction = other->direction;
    partners.circle->feed = other->feed;
    partners.circle->temperature = other->temperature;
  }
  if (run.virtual_bar) partners.bar = store_.source_before(run) == "bar";
  return partners;
}

Service::Judged Service::judge(const Run& run, const RunResult& result, const std::vector<Record>& found) {
  Judged judged;
  alarms_.look();
  const std::vector<AlarmStatus> states = alarms_.states();
  for (const Record& record : found)
    for (const Record& subject : subjects_of(with_harmonics(record, result))) {
      const std::unique_ptr<Past> past = store_.past(subject);
      judge(subject, *past, states, run.ended_us, judged);
    }
  for (AlarmEvent& event : judged.events) event.run_started_us = run.started_us;
  return judged;
}

void Service::judge(const Record& subject, Past& past, const std::vector<AlarmStatus>& states,
                    std::int64_t at_us, Judged& judged) {
  EvaluateResult verdict = rules_.evaluate(subject, past, states, at_us);
  std::move(verdict.statuses.begin(), verdict.statuses.end(), std::back_inserter(judged.states));
  std::move(verdict.events.begin(), verdict.events.end(), std::back_inserter(judged.events));
  for (const RuleError& error : verdict.errors) {
    std::string& last = rule_errors_[error.rule];
    if (last != to_string(error)) log_(Priority::kError, "rule failed: " + to_string(error));
    last = to_string(error);
  }
  for (const AlarmStatus& status : verdict.statuses) rule_errors_.erase(status.key.rule);
}

void Service::tell(const Run& run, const RunResult& result, const std::vector<Record>& found,
                   const Judged& judged) {
  for (const Record& record : found)
    log_(result.status == "ok" ? Priority::kInfo : Priority::kWarning, summary(run, result, record));
  if (publisher_) publisher_->publish(run, result, found);
  alarms_.moved(judged.states, judged.events);
}

void Service::replace_rules(RuleSet rules, bool complete, std::int64_t at_us) {
  rules_ = std::move(rules);
  rule_errors_.clear();
  if (!complete) return;  // a rule that cannot be read is not gone
  const std::vector<AlarmEvent> retired = rules_.retire(alarms_.states(), at_us);
  std::vector<AlarmStatus> states;
  states.reserve(retired.size());
  for (const AlarmEvent& event : retired) states.push_back(event.status);
  if (!retired.empty()) alarms_.change(states, retired);
}

void Service::publish_active_alarms() {
  if (!publisher_) return;
  for (const AlarmStatus& alarm : alarms_.states())
    if (alarm.state == AlarmState::kPending || alarm.state == AlarmState::kFiring) publisher_->publish(alarm);
}

}  // namespace ballbar

#include "daemon/alarm_book.hpp"

#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "daemon/tool.hpp"
#include "rules/alarm_machine.hpp"

namespace ballbar {
namespace {

constexpr std::size_t kMaxUnsaved = 1000;
constexpr std::int64_t kLongestShelvingUs = std::int64_t{366} * 86'400 * 1'000'000;

Priority priority_of(const AlarmEvent& event) {
  const AlarmStatus& alarm = event.status;
  if (event.change != AlarmChange::kState || alarm.state != AlarmState::kFiring || !alarm.shelved.by.empty())
    return Priority::kNotice;
  return alarm.severity == "info"       ? Priority::kNotice
         : alarm.severity == "critical" ? Priority::kError
                                        : Priority::kWarning;
}

/// One line for the journal.
std::string summary(const AlarmEvent& event) {
  const AlarmStatus& alarm = event.status;
  const std::string name = alarm_name(alarm.key) + ", id " + std::to_string(alarm.id);
  if (event.change != AlarmChange::kState) {
    std::string line = std::string("alarm ") + to_string(event.change);
    if (event.change == AlarmChange::kShelved) line += " until " + utc_text(alarm.shelved.until_us) + " UTC";
    return line + (event.by.empty() ? "" : " by " + event.by) + ": " + name +
           (event.comment.empty() ? "" : ": " + event.comment);
  }
  const bool over = alarm.state == AlarmState::kResolved || alarm.state == AlarmState::kInactive;
  return std::string("alarm ") + to_string(alarm.state) + " (" + alarm.severity + ") " + name +
         (alarm.flapping ? ", flapping" : "") + (alarm.shelved.by.empty() ? "" : ", shelved") +
         (over ? ": it was: " : ": ") + alarm.text;
}

AlarmEvent done_to(const AlarmStatus& status, AlarmChange change, const std::string& by,
                   const std::string& comment, std::int64_t now_us) {
  AlarmEvent event{status, status.state};
  event.change = change;
  event.by = by;
  event.comment = comment;
  event.at_us = now_us;
  return event;
}

}  // namespace

std::string alarm_name(const AlarmKey& key) {
  std::string name = key.rule;
  if (!key.robot.empty()) name += " " + key.robot;
  if (!key.test.empty()) name += " " + key.test;
  if (key.direction != 0) name += key.direction > 0 ? "+1" : "-1";
  if (!key.axis.empty()) name += " " + key.axis;
  return name;
}

AlarmBook::AlarmBook(Store& store, Log log, Heard heard)
    : store_(store), log_(std::move(log)), heard_(std::move(heard)) {
  version_ = data_version();
  for (AlarmStatus& alarm : store_.alarm_states()) alarms_[alarm.key] = std::move(alarm);
}

std::int64_t AlarmBook::data_version() const { return store_.database().integer("PRAGMA data_version"); }

void AlarmBook::look() {
  try {
    const std::int64_t version = data_version();
    if (version == version_) return;
    std::map<AlarmKey, AlarmStatus> stored;
    for (AlarmStatus& alarm : store_.alarm_states()) stored[alarm.key] = std::move(alarm);
    for (const AlarmStatus& alarm : unsaved_) stored[alarm.key] = alarm;
    alarms_ = std::move(stored);
    version_ = version;
  } catch (const StoreError&) {  // what is known stands; whoever stores something will say what is wrong
  }
}

void AlarmBook::on_new_store() {
  unsaved_ = states();
  version_ = -1;  // the next look reads what it holds
  retry();
}

std::vector<AlarmStatus> AlarmBook::states() const {
  std::vector<AlarmStatus> states;
  for (const auto& [key, status] : alarms_) states.push_back(status);
  return states;
}

int AlarmBook::firing() const {
  return static_cast<int>(std::count_if(alarms_.begin(), alarms_.end(), [](const auto& entry) {
    return entry.second.state == AlarmState::kFiring;
  }));
}

const AlarmStatus& AlarmBook::find(std::int64_t id) const {
  for (const auto& [key, status] : alarms_)
    if (status.id == id && id > 0) return status;
  throw Error(Cause::kInput, "no alarm has the id " + std::to_string(id) + "; 'ballbar alarms' shows all");
}

void AlarmBook::number(std::vector<AlarmStatus>& states, std::vector<AlarmEvent>& events) const {
  std::int64_t last = 0;
  for (const auto& [key, status] : alarms_) last = std::max(last, status.id);
  for (AlarmStatus& status : states) {
    if (status.id != 0) continue;
    const auto known = alarms_.find(status.key);
    status.id = known != alarms_.end() && known->second.id != 0 ? known->second.id : ++last;
    for (AlarmEvent& event : events)
      if (event.status.key == status.key) event.status.id = status.id;
  }
}

void AlarmBook::moved(const std::vector<AlarmStatus>& states, const std::vector<AlarmEvent>& events) {
  std::erase_if(unsaved_, [&states](const AlarmStatus& old) {  // what is stored now is newer
    return std::any_of(states.begin(), states.end(), [&old](const auto& now) { return now.key == old.key; });
  });
  stand(states);
  for (const AlarmEvent& event : events) say(event);
}

void AlarmBook::stand(const std::vector<AlarmStatus>& states) {
  for (const AlarmStatus& state : states) alarms_[state.key] = state;
}

void AlarmBook::change(const std::vector<AlarmStatus>& states, const std::vector<AlarmEvent>& events) {
  unsaved_.insert(unsaved_.end(), states.begin(), states.end());
  unsaved_events_.insert(unsaved_events_.end(), events.begin(), events.end());
  if (unsaved_.size() > kMaxUnsaved) unsaved_.erase(unsaved_.begin(), unsaved_.end() - kMaxUnsaved);
  if (unsaved_events_.size() > kMaxUnsaved)
    unsaved_events_.erase(unsaved_events_.begin(), unsaved_events_.end() - kMaxUnsaved);
  retry();
  stand(states);
  for (const AlarmEvent& event : events) say(event);
}

void AlarmBook::retry() {
  if (unsaved_.empty() && unsaved_events_.empty()) return;
  try {
    store_.save_alarms(unsaved_, unsaved_events_);
    unsaved_.clear();
    unsaved_events_.clear();
    said_.clear();
  } catch (const StoreError& error) {
    const std::string said = std::string("alarms wait in memory and are tried again: ") + error.what();
    if (said != said_) log_(Priority::kError, said);
    said_ = said;
  }
}

void AlarmBook::own(const std::string& rule, bool bad, const std::string& text, std::int64_t now_us,
                    const std::string& severity) {
  const AlarmKey key{rule, "", "", 0, ""};
  const auto known = alarms_.find(key);
  const bool fires = known != alarms_.end() && known->second.state == AlarmState::kFiring;
  if (fires && bad && known->second.text != text) {
    AlarmStatus other_words = known->second;
    other_words.text = text;
    return change({other_words}, {});
  }
  if (fires == bad) return;
  AlarmStatus before = known != alarms_.end() ? known->second : AlarmStatus{};
  before.key = key;
  before.severity = severity;
  if (bad) before.text = text;
  const AlarmDelays at_once{1, 0, 0.0, 0.0, 0, 1};
  std::vector<AlarmStatus> states{advance(before, bad, at_once, now_us)};
  std::vector<AlarmEvent> events{{states.front(), before.state}};
  number(states, events);
  change(states, events);
}

void AlarmBook::store_and_say(const AlarmStatus& status, const AlarmEvent& event) {
  retry();
  store_.save_alarms({status}, {event});
  moved({status}, {event});
}

void AlarmBook::acknowledge(std::int64_t id, const std::string& by, const std::string& comment,
                            std::int64_t now_us) {
  look();
  AlarmStatus status = find(id);
  if (status.state != AlarmState::kFiring)
    throw Error(Cause::kInput, "alarm " + std::to_string(id) + " (" + alarm_name(status.key) + ") is " +
                                   to_string(status.state) + "; only one that fires can be acknowledged");
  status.acknowledged = {by, comment, now_us};
  store_and_say(status, done_to(status, AlarmChange::kAcknowledged, by, comment, now_us));
}

void AlarmBook::shelve(std::int64_t id, std::int64_t until_us, const std::string& by,
                       const std::string& comment, std::int64_t now_us) {
  look();
  AlarmStatus status = find(id);
  if (until_us <= now_us || until_us - now_us > kLongestShelvingUs)
    throw Error(Cause::kInput, "an alarm is shelved until a time to come, at most 366 days from now, not " +
                                   utc_text(until_us) + " UTC");
  status.shelved = {by, comment, until_us};
  store_and_say(status, done_to(status, AlarmChange::kShelved, by, comment, now_us));
}

void AlarmBook::unshelve(std::int64_t id, const std::string& by, const std::string& comment,
                         std::int64_t now_us) {
  look();
  AlarmStatus status = find(id);
  if (status.shelved.by.empty())
    throw Error(Cause::kInput,
                "alarm " + std::to_string(id) + " (" + alarm_name(status.key) + ") is not shelved");
  status.shelved = {};
  store_and_say(status, done_to(status, AlarmChange::kUnshelved, by, comment, now_us));
}

void AlarmBook::tick(std::int64_t now_us) {
  look();
  for (const AlarmStatus& shelved : states()) {
    if (shelved.shelved.by.empty() || shelved.shelved.until_us > now_us) continue;
    AlarmStatus status = shelved;
    status.shelved = {};
    change({status}, {done_to(status, AlarmChange::kUnshelved, "", "its time is over", now_us)});
  }
}

void AlarmBook::say(const AlarmEvent& event) const {
  log_(priority_of(event), summary(event));
  heard_(event.status);
}

}  // namespace ballbar

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "store/store.hpp"
#include "store/stored_alarms.hpp"

namespace ballbar {
namespace {

constexpr const char* kStateColumns =
    "rule, robot, test, direction, axis, state, severity, since_us, judged_us, bad_runs, clean_runs, text, "
    "id, "
    "streak_us, fires, flapping, numbers, runs, acknowledged_by, acknowledged_comment, acknowledged_us, "
    "shelved_by, shelved_comment, shelved_until_us";

/// Twelve digits: more than any of them is known to.
std::string number_text(double value) {
  if (!std::isfinite(value)) throw std::invalid_argument("a number of an alarm is not finite");
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", value);
  return text;
}

/// Names are of small letters, digits and _: nothing in them needs an escape.
std::string numbers_json(const std::vector<AlarmNumber>& numbers) {
  std::string json = "[";
  for (const AlarmNumber& number : numbers) {
    if (json.size() > 1) json += ',';
    json.append(R"({"name":")").append(number.name).append(R"(","value":)").append(number_text(number.value));
    if (number.sd) json.append(R"(,"sd":)").append(number_text(*number.sd));
    json.append(R"(,"of":)").append(number.of_rule ? R"("rule"})" : R"("run"})");
  }
  return json + "]";
}

std::vector<AlarmNumber> read_numbers(Database& db, const std::string& json) {
  std::vector<AlarmNumber> numbers;
  if (json == "[]") return numbers;
  Statement query(db,
                  "SELECT value ->> '$.name', value ->> '$.value', value ->> '$.sd', value ->> '$.of' "
                  "FROM json_each(?1)");
  query.bind(json);
  while (query.step())
    numbers.push_back({query.text(0), query.real(1), query.maybe_real(2), query.text(3) == "rule"});
  return numbers;
}

std::string runs_json(const std::vector<std::int64_t>& runs) {
  std::string json = "[";
  for (const std::int64_t run : runs) json += (json.size() > 1 ? "," : "") + std::to_string(run);
  return json + "]";
}

std::vector<std::int64_t> read_runs(Database& db, const std::string& json) {
  std::vector<std::int64_t> runs;
  if (json == "[]") return runs;
  Statement query(db, "SELECT value FROM json_each(?1)");
  query.bind(json);
  while (query.step()) runs.push_back(query.integer(0));
  return runs;
}

AlarmKey read_key(const Statement& row, int first) {
  return {row.text(first), row.text(first + 1), row.text(first + 2), row.small(first + 3),
          row.text(first + 4)};
}

/// Columns 0 to 11 as in kStateColumns, 12 the id, then numbers and runs at `numbers`.
AlarmStatus read_common(Database& db, const Statement& row, int numbers) {
  AlarmStatus s;
  s.key = read_key(row, 0);
  s.state = alarm_state_from(row.text(5));
  s.severity = row.text(6);
  s.since_us = row.integer(7);
  s.judged_us = row.integer(8);
  s.bad_runs = row.small(9);
  s.clean_runs = row.small(10);
  s.text = row.text(11);
  s.id = row.integer(12);
  s.numbers = read_numbers(db, row.text(numbers));
  s.runs = read_runs(db, row.text(numbers + 1));
  return s;
}

}  // namespace

void put_states(Database& db, const std::vector<AlarmStatus>& states) {
  Statement put(db,
                std::string("INSERT OR REPLACE INTO alarm_state (") + kStateColumns +
                    ") VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, "
                    "?18, ?19, ?20, ?21, ?22, ?23, ?24)");
  for (const AlarmStatus& s : states)
    put.bind(s.key.rule, s.key.robot, s.key.test, s.key.direction, s.key.axis, to_string(s.state), s.severity,
             s.since_us, s.judged_us, s.bad_runs, s.clean_runs, s.text, s.id, s.streak_us, s.fires,
             s.flapping ? 1 : 0, numbers_json(s.numbers), runs_json(s.runs), s.acknowledged.by,
             s.acknowledged.comment, s.acknowledged.at_us, s.shelved.by, s.shelved.comment,
             s.shelved.until_us)
        .run();
}

void insert_events(Database& db, const std::vector<AlarmEvent>& events) {
  Statement insert(
      db,
      "INSERT INTO alarm_event (rule, robot, test, direction, axis, from_state, to_state, severity, at_us, "
      "judged_us, bad_runs, clean_runs, run_id, run_started_us, text, alarm_id, change, by_whom, comment, "
      "since_us, shelved_until_us, numbers, runs) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, "
      "(SELECT id FROM run WHERE robot = ?2 AND started_us = ?13), ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, "
      "?21, ?22)");
  for (const AlarmEvent& e : events) {
    const AlarmStatus& s = e.status;
    insert
        .bind(s.key.rule, s.key.robot, s.key.test, s.key.direction, s.key.axis, to_string(e.from),
              to_string(s.state), s.severity, e.at_us != 0 ? e.at_us : s.since_us, s.judged_us, s.bad_runs,
              s.clean_runs, e.run_started_us, s.text, s.id, to_string(e.change), e.by, e.comment, s.since_us,
              s.shelved.until_us, numbers_json(s.numbers), runs_json(s.runs))
        .run();
  }
}

void Store::save_alarms(const std::vector<AlarmStatus>& states, const std::vector<AlarmEvent>& events) {
  Transaction transaction(*db_);
  put_states(*db_, states);
  insert_events(*db_, events);
  transaction.commit();
}

std::vector<AlarmStatus> Store::alarm_states() const {
  Statement query(*db_, std::string("SELECT ") + kStateColumns +
                            " FROM alarm_state ORDER BY rule, robot, test, direction, axis");
  std::vector<AlarmStatus> states;
  while (query.step()) {
    AlarmStatus& s = states.emplace_back(read_common(*db_, query, 16));
    s.streak_us = query.integer(13);
    s.fires = query.integer(14);
    s.flapping = query.integer(15) != 0;
    s.acknowledged = {query.text(18), query.text(19), query.integer(20)};
    s.shelved = {query.text(21), query.text(22), query.integer(23)};
  }
  return states;
}

std::vector<StoredEvent> Store::events(const EventFilter& filter) const {
  const std::string by = filter.after_id ? "id" : "at_us, id";
  Statement query(
      *db_,
      "SELECT rule, robot, test, direction, axis, to_state, severity, since_us, judged_us, bad_runs, "
      "clean_runs, text, alarm_id, id, run_id, from_state, run_started_us, change, by_whom, comment, at_us, "
      "shelved_until_us, numbers, runs FROM alarm_event "
      "WHERE (?1 IS NULL OR robot = ?1) AND (?2 IS NULL OR test = ?2) AND (?3 IS NULL OR rule = ?3) "
      "AND (?4 IS NULL OR run_id = ?4) AND (?5 IS NULL OR at_us >= ?5) AND (?6 IS NULL OR alarm_id = ?6) "
      "AND (?7 IS NULL OR id > ?7) AND (?8 = 0 OR change = 'state') ORDER BY " +
          (filter.newest_first ? "at_us DESC, id DESC" : by) + " LIMIT ?9");
  query.bind(filter.robot, filter.test, filter.rule, filter.run_id, filter.since_us, filter.alarm_id,
             filter.after_id, filter.states_only ? 1 : 0,
             filter.limit > 0 ? filter.limit : std::int64_t{-1});  // SQLite: negative = all
  std::vector<StoredEvent> events;
  while (query.step()) {
    StoredEvent& stored = events.emplace_back();
    stored.id = query.integer(13);
    stored.run_id = query.maybe_integer(14);
    AlarmEvent& event = stored.event;
    event.status = read_common(*db_, query, 22);
    event.from = alarm_state_from(query.text(15));
    event.run_started_us = query.integer(16);
    event.change = alarm_change_from(query.text(17));
    event.by = query.text(18);
    event.comment = query.text(19);
    event.at_us = query.integer(20);
    event.status.shelved.until_us = query.integer(21);
  }
  return events;
}

std::int64_t Store::last_event() const { return db_->integer("SELECT max(id) FROM alarm_event"); }

std::optional<std::int64_t> Store::notified() const {
  Statement query(*db_, "SELECT event FROM notified");
  if (!query.step()) return std::nullopt;
  return query.integer(0);
}

void Store::save_notified(std::int64_t event_id) {
  Statement(*db_, "INSERT OR REPLACE INTO notified (one, event) VALUES (1, ?1)").bind(event_id).run();
}

void Store::forget_notified() {
  if (notified()) db_->execute("DELETE FROM notified");
}

std::optional<RuleGeneration> Store::last_rules() const {
  Statement last(*db_, "SELECT generation, taken_us FROM rule_generation ORDER BY generation DESC LIMIT 1");
  if (!last.step()) return std::nullopt;
  RuleGeneration rules{last.small(0), last.integer(1), {}};
  Statement files(*db_, "SELECT file, text FROM rule_file WHERE generation = ?1 ORDER BY place");
  files.bind(rules.generation);
  while (files.step()) rules.files.emplace_back(files.text(0), files.text(1));
  return rules;
}

int Store::save_rules(const std::vector<std::pair<std::string, std::string>>& files, std::int64_t taken_us) {
  Transaction transaction(*db_);
  const int generation = 1 + static_cast<int>(db_->integer("SELECT max(generation) FROM rule_generation"));
  Statement(*db_, "INSERT INTO rule_generation (generation, taken_us) VALUES (?1, ?2)")
      .bind(generation, taken_us)
      .run();
  Statement insert(*db_, "INSERT INTO rule_file (generation, place, file, text) VALUES (?1, ?2, ?3, ?4)");
  int place = 0;
  for (const auto& [file, text] : files) insert.bind(generation, place++, file, text).run();
  Statement(*db_, "DELETE FROM rule_generation WHERE generation <= ?1")
      .bind(generation - kKeptGenerations)
      .run();
  transaction.commit();
  return generation;
}

}  // namespace ballbar

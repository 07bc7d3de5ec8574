// Alarms as the service keeps them: what time does to them, what is told, and a database that cannot be
// written.

#include "daemon/alarm_book.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.hpp"
#include "daemon/notifier.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kNow = 1'700'000'000'000'000;
constexpr std::int64_t kMinute = 60'000'000;

class Book : public testing::Test {
 protected:
  AlarmBook book() {
    return AlarmBook(
        store, [this](Priority, const std::string& line) { lines.push_back(line); },
        [this](const AlarmStatus& alarm) { heard.push_back(alarm); });
  }
  std::vector<std::string> changes() {
    EventFilter all;
    all.states_only = false;
    all.after_id = 0;
    std::vector<std::string> words;
    for (const StoredEvent& stored : store.events(all))
      words.push_back(std::string(to_string(stored.event.change)) + " " +
                      to_string(stored.event.status.state));
    return words;
  }
  using Words = std::vector<std::string>;

  test::TempDir dir;
  Store store{dir.path() + "/a.db", StoreOptions{50}};
  Words lines;
  std::vector<AlarmStatus> heard;
};

TEST_F(Book, ShelvingEndsByTimeAndNotBefore) {
  AlarmBook alarms = book();
  alarms.own(kRulesAlarm, true, "why", kNow);
  alarms.shelve(1, kNow + kMinute, "anna", "repair", kNow);
  alarms.tick(kNow + kMinute - 1);
  EXPECT_EQ(alarms.find(1).shelved.by, "anna");
  alarms.tick(kNow + kMinute);
  EXPECT_EQ(alarms.find(1).shelved, Shelving{});
  EXPECT_EQ(changes(), (Words{"state firing", "shelved firing", "unshelved firing"}));
  EXPECT_EQ(heard.size(), 3u) << "each of them is on the bus";
  AlarmBook again = book();
  again.tick(kNow + 2 * kMinute);
  EXPECT_EQ(changes().size(), 3u);
}

TEST_F(Book, AnAlarmOfBallbardItselfIsSaidOnceWhateverItsWords) {
  AlarmBook alarms = book();
  alarms.own(kNotifyAlarm, false, "", kNow);  // never was one
  EXPECT_TRUE(changes().empty());
  alarms.own(kNotifyAlarm, true, "exit code 1", kNow);
  alarms.own(kNotifyAlarm, true, "exit code 2", kNow + 1);
  EXPECT_EQ(store.alarm_states().at(0).text, "exit code 2") << "but what is shown is up to date";
  alarms.own(kNotifyAlarm, false, "", kNow + 2);
  alarms.own(kNotifyAlarm, true, "exit code 3", kNow + 3);
  EXPECT_EQ(changes(), (Words{"state firing", "state resolved", "state firing"}));
  EXPECT_EQ(alarms.find(1).since_us, kNow + 3);
}

TEST_F(Book, NumbersAreGivenOnce) {
  AlarmBook alarms = book();
  alarms.own(kRulesAlarm, true, "why", kNow);
  alarms.own(kNotifyAlarm, true, "why", kNow);
  AlarmStatus of_rule;
  of_rule.key = {"high", "r", "A", 1, ""};
  std::vector<AlarmStatus> states{of_rule, of_rule};
  states[1].key.direction = -1;
  std::vector<AlarmEvent> events{{states[1], AlarmState::kInactive}};
  alarms.number(states, events);
  EXPECT_EQ(states[0].id, 3);
  EXPECT_EQ(states[1].id, 4);
  EXPECT_EQ(events[0].status.id, 4);
}

TEST_F(Book, WhileTheDatabaseIsLockedItsOwnAlarmsWaitAndWhatPeopleSayIsRefused) {
  AlarmBook alarms = book();
  alarms.own(kRulesAlarm, true, "why", kNow);
  Database other(store.path(), Database::Mode::kReadWrite, 50);
  other.execute("BEGIN IMMEDIATE");
  EXPECT_THROW(alarms.acknowledge(1, "anna", "", kNow), StoreError);
  EXPECT_EQ(alarms.find(1).acknowledged.by, "") << "what is not stored has not happened";
  alarms.own(kNotifyAlarm, true, "fails", kNow);
  EXPECT_EQ(alarms.firing(), 2) << "but an alarm stands";
  EXPECT_EQ(changes().size(), 1u);
  other.execute("ROLLBACK");
  alarms.retry();
  EXPECT_EQ(changes(), (Words{"state firing", "state firing"}));
  EXPECT_EQ(store.alarm_states().size(), 2u);
}

TEST_F(Book, WhatARunHasStoredIsNotOverwrittenByWhatWaitedBefore) {
  AlarmBook alarms = book();
  Database other(store.path(), Database::Mode::kReadWrite, 50);
  other.execute("BEGIN IMMEDIATE");
  alarms.own(kRulesAlarm, true, "why", kNow);
  other.execute("ROLLBACK");
  AlarmStatus newer = alarms.find(1);
  newer.text = "newer";
  store.save_alarms({newer}, {});
  alarms.moved({newer}, {});
  alarms.retry();
  EXPECT_EQ(store.alarm_states().at(0).text, "newer");
  EXPECT_EQ(changes(), (Words{"state firing"})) << "but what has happened is told";
}

TEST_F(Book, WhatIsJudgedAgainWhileItWaitsToBeStoredStillIsStored) {
  AlarmBook alarms = book();
  Database other(store.path(), Database::Mode::kReadWrite, 50);
  other.execute("BEGIN IMMEDIATE");
  alarms.own(kRulesAlarm, true, "why", kNow);
  alarms.stand({alarms.find(1)});  // a minute later it is the same
  EXPECT_EQ(alarms.unsaved(), 1u);
  other.execute("ROLLBACK");
  alarms.retry();
  ASSERT_EQ(store.alarm_states().size(), 1u);
  EXPECT_EQ(store.alarm_states()[0].state, AlarmState::kFiring);
}

TEST_F(Book, TheSameTroubleOfTheDatabaseIsSaidOnce) {
  AlarmBook alarms = book();
  Database other(store.path(), Database::Mode::kReadWrite, 50);
  other.execute("BEGIN IMMEDIATE");
  alarms.own(kRulesAlarm, true, "why", kNow);
  for (int i = 0; i < 5; ++i) alarms.retry();
  EXPECT_EQ(std::count_if(lines.begin(), lines.end(),
                          [](const std::string& line) { return line.starts_with("alarms wait in memory"); }),
            1);
}

TEST_F(Book, AlarmsThatAnotherProgramHasMovedAreTakenOver) {
  AlarmBook alarms = book();
  alarms.own(kRulesAlarm, true, "why", kNow);
  {  // ballbar replay into the same database
    Store other(store.path());
    AlarmStatus of_rule;
    of_rule.key = {"high", "r", "A", 1, ""};
    of_rule.state = AlarmState::kFiring;
    of_rule.id = 2;
    other.save_alarms({of_rule}, {});
  }
  alarms.acknowledge(2, "anna", "known", kNow);
  alarms.own(kNotifyAlarm, true, "fails", kNow);
  EXPECT_EQ(alarms.find(3).key.rule, kNotifyAlarm) << "no number is given twice";
  EXPECT_EQ(store.alarm_states().size(), 3u);
}

TEST_F(Book, InANewStoreTheySimplyGoOn) {
  AlarmBook alarms = book();
  alarms.own(kRulesAlarm, true, "why", kNow);
  alarms.acknowledge(1, "anna", "known", kNow);
  store = Store(dir.path() + "/b.db", StoreOptions{50});
  alarms.on_new_store();
  AlarmBook again = book();
  EXPECT_EQ(again.find(1).acknowledged.by, "anna");
  EXPECT_EQ(again.firing(), 1);
}

TEST(Notify, IsOfAlarmsThatFireOrAreOver) {
  struct Row {
    AlarmChange change;
    AlarmState from, to;
    const char* severity;
    const char* least;
    bool shelved, told;
  };
  using enum AlarmState;
  using enum AlarmChange;
  const std::vector<Row> rows{
      {kState, kPending, kFiring, "warning", "warning", false, true},
      {kState, kInactive, kFiring, "critical", "warning", false, true},
      {kState, kFiring, kResolved, "warning", "warning", false, true},
      {kState, kFiring, kInactive, "warning", "info", false, true},  // its rule is gone
      {kState, kInactive, kPending, "critical", "info", false, false},
      {kState, kResolved, kInactive, "critical", "info", false, false},
      {kState, kPending, kFiring, "info", "warning", false, false},
      {kState, kPending, kFiring, "warning", "critical", false, false},
      {kState, kPending, kFiring, "critical", "info", true, false},
      {kAcknowledged, kFiring, kFiring, "critical", "info", false, false},
      {kShelved, kFiring, kFiring, "critical", "info", true, false},
      {kUnshelved, kFiring, kFiring, "warning", "warning", false, true},
      {kUnshelved, kResolved, kResolved, "warning", "warning", false, false},
  };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    AlarmEvent event;
    event.status.key = {"high", "r", "A", 1, ""};
    event.status.state = row.to;
    event.status.severity = row.severity;
    if (row.shelved) event.status.shelved.until_us = kNow;
    event.from = row.from;
    event.change = row.change;
    EXPECT_EQ(worth_telling(event, row.least), row.told) << "row " << i;
    event.status.key.rule = kNotifyAlarm;
    EXPECT_FALSE(worth_telling(event, row.least)) << "its own failure, row " << i;
  }
}

}  // namespace
}  // namespace ballbar

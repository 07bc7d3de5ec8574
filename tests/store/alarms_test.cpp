/// Alarms with all that belongs to them, sets of rules, and what people were told of: as saved, so read.

#include <gtest/gtest.h>

#include <limits>

#include "store/example_runs.hpp"
#include "store/migrations.hpp"
#include "store/schema.hpp"
#include "store/store.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

AlarmStatus full_alarm() {
  AlarmStatus a = test::alarm(test::circle(), AlarmState::kFiring);
  a.id = 7;
  a.streak_us = test::kDay - 5;
  a.fires = (std::int64_t{1} << 59) + 5;
  a.flapping = true;
  a.numbers = {
      {"ovality_um", 31.25, 0.125, false}, {"over_um", 6.25, {}, false}, {"limit_um", 25.0, {}, true}};
  a.runs = {test::kDay - 200, test::kDay - 100, test::kDay};
  a.acknowledged = {"anna (operator)", "ball \"cup\" \\ loose, 5 µm", test::kDay + 1};
  a.shelved = {"root", "repair on Monday", test::kDay + 2};
  return a;
}

class StoredAlarms : public testing::Test {
 protected:
  test::TempDir dir;
  std::string path = dir.path() + "/b.db";
};

TEST_F(StoredAlarms, AnAlarmWithAllThatBelongsToItSurvivesARestart) {
  Store(path).save_alarms({full_alarm()}, {});
  EXPECT_EQ(Store(path).alarm_states(), std::vector<AlarmStatus>{full_alarm()});
}

TEST_F(StoredAlarms, WhatPeopleDidIsInTheHistoryButIsNoChangeOfState) {
  Store store(path);
  const AlarmStatus alarm = full_alarm();
  AlarmEvent acknowledged{alarm, AlarmState::kFiring};
  acknowledged.change = AlarmChange::kAcknowledged;
  acknowledged.by = "anna";
  acknowledged.comment = "seen";
  acknowledged.at_us = alarm.since_us - 1000;  // another clock: its time may lie before
  store.save_alarms({alarm}, {{alarm, AlarmState::kPending, test::kDay}, acknowledged});
  EXPECT_EQ(store.events().size(), 1u);
  EventFilter all;
  all.alarm_id = 7;
  all.states_only = false;
  all.after_id = 0;
  const std::vector<StoredEvent> events = store.events(all);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].event.change, AlarmChange::kState);
  EXPECT_EQ(events[0].event.at_us, alarm.since_us);
  EXPECT_EQ(events[0].event.status.numbers, alarm.numbers);
  EXPECT_EQ(events[0].event.status.runs, alarm.runs);
  EXPECT_EQ(events[1].event.change, AlarmChange::kAcknowledged);
  EXPECT_EQ(events[1].event.by, "anna");
  EXPECT_EQ(events[1].event.comment, "seen");
  EXPECT_EQ(events[1].event.at_us, alarm.since_us - 1000);
  EXPECT_EQ(events[1].event.status.since_us, alarm.since_us);
  all.after_id = events[0].id;
  EXPECT_EQ(store.events(all).size(), 1u);
  all.alarm_id = 8;
  EXPECT_TRUE(store.events(all).empty());
}

TEST_F(StoredAlarms, ANumberThatIsNotFiniteIsRefusedAndNothingIsStored) {
  Store store(path);
  AlarmStatus alarm = full_alarm();
  alarm.numbers[1].value = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(store.save_alarms({alarm}, {}), std::invalid_argument);
  EXPECT_TRUE(store.alarm_states().empty());
}

TEST_F(StoredAlarms, AlarmsOfAnOlderDatabaseGetNumbersAndTheirHistory) {
  {
    Database db(path, Database::Mode::kReadWrite, 20);
    std::size_t before = 0;  // the steps before the one that numbers alarms
    while (std::string(schema_steps()[before]).find("alarm_state ADD COLUMN id") == std::string::npos)
      ++before;
    migrate(db, schema_steps().first(before));
    db.execute(
        "INSERT INTO alarm_state VALUES ('b', 'r', 'A', 1, '', 'pending', 'warning', 10, 30, 2, 0, 't');"
        "INSERT INTO alarm_state VALUES ('a', 'r', 'Y', -1, 'Z', 'firing', 'critical', 20, 40, 0, 1, 't');"
        "INSERT INTO alarm_event VALUES (5, 'b', 'r', 'A', 1, '', 'inactive', 'pending', 'warning', 10, 10, "
        "1, 0, "
        "NULL, 1, 't')");
  }
  const Store store(path);
  const std::vector<AlarmStatus> alarms = store.alarm_states();
  ASSERT_EQ(alarms.size(), 2u);
  EXPECT_EQ(alarms[0].key.rule, "a");
  EXPECT_EQ(alarms[0].id, 1);
  EXPECT_EQ(alarms[0].streak_us, 40) << "how long it has been clean is not known: from now on";
  EXPECT_EQ(alarms[1].id, 2);
  EXPECT_EQ(alarms[1].streak_us, 10) << "pending since its first bad run";
  EventFilter filter;
  filter.alarm_id = 2;
  ASSERT_EQ(store.events(filter).size(), 1u);
  EXPECT_EQ(store.events(filter)[0].event.status.since_us, 10);
}

TEST_F(StoredAlarms, TheLastSetOfRulesIsThereAfterARestartAndOldOnesGo) {
  using Files = std::vector<std::pair<std::string, std::string>>;
  {
    Store store(path);
    EXPECT_FALSE(store.last_rules());
    EXPECT_EQ(store.save_rules({{"z.lua", "return 'ü'"}, {"a.lua", std::string("b\0c", 3)}}, 5), 1);
    EXPECT_EQ(store.save_rules({}, 6), 2) << "no rules is a set, too";
  }
  Store store(path);
  EXPECT_EQ(store.last_rules()->generation, 2);
  EXPECT_TRUE(store.last_rules()->files.empty());
  const Files files{{"z.lua", "1"}, {"a.lua", "2"}};
  for (int i = 0; i < 2 * kKeptGenerations; ++i) store.save_rules(files, 7);
  EXPECT_EQ(store.last_rules()->generation, 2 + 2 * kKeptGenerations);
  EXPECT_EQ(store.last_rules()->taken_us, 7);
  EXPECT_EQ(store.last_rules()->files, files);
  EXPECT_EQ(store.database().integer("SELECT count(*) FROM rule_generation"), kKeptGenerations);
  EXPECT_EQ(store.database().integer("SELECT count(*) FROM rule_file"), 2 * kKeptGenerations);
}

TEST_F(StoredAlarms, WhatPeopleWereToldOfIsOneNumberOrNone) {
  Store store(path);
  EXPECT_EQ(store.last_event(), 0);
  EXPECT_FALSE(store.notified());
  store.save_notified(3);
  store.save_notified(4);
  EXPECT_EQ(Store(path).notified(), 4);
  store.forget_notified();
  EXPECT_FALSE(Store(path).notified());
  store.save_alarms({}, {{full_alarm(), AlarmState::kPending, test::kDay}});
  EXPECT_EQ(store.last_event(), 1);
}

}  // namespace
}  // namespace ballbar

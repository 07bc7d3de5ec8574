// The database of the real service, damaged, locked, held by readers, or without room, at the start and
// later.

#include <gtest/gtest.h>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <sstream>

#include "daemon/housekeeping.hpp"
#include "fault/fault_fixture.hpp"

namespace ballbar {
namespace {

TEST_F(Fault, WhileAnotherProgramHoldsTheDatabaseAlsoAtTheStartRunsWait) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 1);
  ASSERT_TRUE(published(1)) << daemon.log();
  ASSERT_EQ(daemon.stop(), 0) << daemon.log();
  {
    Database other(daemon.db(), Database::Mode::kReadWrite, 1000);
    const Transaction transaction(other);
    daemon.start();
    ASSERT_TRUE(daemon.ready()) << daemon.log();
    send(2, 2);
    EXPECT_TRUE(daemon.says("another program holds the database")) << daemon.log();
  }
  EXPECT_TRUE(published(2)) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 2);
}

TEST_F(Fault, AReaderThatHoldsTheWalHoldsNoRunUpAndTheWalShrinksBehindIt) {
  const auto wal_bytes = [](const LiveDaemon& daemon) {
    return std::filesystem::file_size(daemon.db() + "-wal");
  };
  constexpr std::uintmax_t kLimit = std::uintmax_t{4} << 20;
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 1);
  ASSERT_TRUE(published(1)) << daemon.log();
  std::int64_t last = 1;
  {
    Store reader = Store::open_read_only(daemon.db());
    const Snapshot snapshot(reader.database());
    ASSERT_EQ(reader.database().integer("SELECT count(*) FROM run"), 1);
    while (wal_bytes(daemon) < kLimit + kLimit / 4 && last < 1000) {
      send(last + 1, last + 20);
      last += 20;
      ASSERT_TRUE(published(static_cast<std::size_t>(last))) << daemon.log();
    }
    EXPECT_GT(wal_bytes(daemon), kLimit) << "the reader holds it";
    EXPECT_EQ(reader.database().integer("SELECT count(*) FROM run"), 1) << "and sees what it saw";
  }
  for (int i = 0; i < 2; ++i) {
    ++last;
    send(last, last);
    ASSERT_TRUE(published(static_cast<std::size_t>(last))) << daemon.log();
  }
  EXPECT_LE(wal_bytes(daemon), kLimit + 4096) << last << " circles";
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, last);
}

TEST(Housekeeping, SaysThatAReaderHoldsALargeWalAndEmptiesItAsSoonAsItMay) {
  const test::TempDir dir;
  Store store(dir.path() + "/b.db");
  const auto wal_bytes = [&] { return std::filesystem::file_size(store.path() + "-wal"); };
  Housekeeping housekeeping;
  const auto a_minute_later = [&] {
    std::vector<std::string> lines;
    for (int second = 0; second < 60; ++second)
      for (const std::string& line : housekeeping.on_second(store, Config{}, DaemonStatus{}, {}))
        lines.push_back(line);
    return lines;
  };
  {
    Store reader = Store::open_read_only(store.path());
    const Snapshot snapshot(reader.database());
    reader.database().integer("SELECT count(*) FROM run");
    store.database().execute("CREATE TABLE large (bytes)");
    store.database().execute("INSERT INTO large VALUES (zeroblob(70000000))");
    store.database().execute("DROP TABLE large");
    const std::vector<std::string> lines = a_minute_later();
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_NE(lines[0].find("MB: a program holds the database open for reading; close it"), std::string::npos)
        << lines[0];
    EXPECT_GT(wal_bytes(), 70'000'000u);
    EXPECT_TRUE(a_minute_later().empty()) << "once is enough";
  }
  EXPECT_TRUE(a_minute_later().empty());
  EXPECT_EQ(wal_bytes(), 0u);
}

TEST(Housekeeping, WritesWhatItCountsAsACollectorReadsIt) {
  const test::TempDir dir;
  Store store(dir.path() + "/b.db");
  Config config;
  config.metrics_path = dir.path() + "/ballbard.prom";
  DaemonStatus status;
  status.version = "1.2.3";
  status.state = "listening";
  RefusedByReason refused{};
  refused[static_cast<std::size_t>(Refusal::kUnknownRobot)] = 41;
  status.kernel_drops = 7;
  EXPECT_EQ(Housekeeping().on_second(store, config, status, refused), std::vector<std::string>{});
  std::istringstream text(test::read_file(config.metrics_path));
  std::map<std::string, std::string> values, types;
  for (std::string line; std::getline(text, line);) {
    std::istringstream words(line);
    std::string first, second, third;
    words >> first >> second >> third;
    if (first == "#" && second == "TYPE") {
      words >> types[third];
    } else if (first != "#") {
      EXPECT_TRUE(third.empty() && types.contains(first.substr(0, first.find('{')))) << line;
      values[first] = second;
    }
  }
  EXPECT_EQ(values["ballbard_info{version=\"1.2.3\"}"], "1");
  EXPECT_EQ(values["ballbard_listening"], "1");
  EXPECT_EQ(values["ballbard_messages_refused_total{reason=\"unknown_robot\"}"], "41");
  EXPECT_EQ(values["ballbard_datagrams_dropped_total"], "7");
  EXPECT_EQ(types["ballbard_datagrams_dropped_total"], "counter");
  EXPECT_GT(std::stoll(values["ballbard_database_bytes"]), 4096);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(dir.path()), {}), 4) << "no draft stays behind";
}

/// Garbage over all pages but the first.
void damage(const std::string& db) {
  std::string bytes = test::read_file(db);
  ASSERT_GT(bytes.size(), 3u * 4096);
  std::fstream file(db, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(4096);
  file << std::string(bytes.size() - 4096, '\x7f');
}

TEST_F(Fault, ADatabaseThatIsDamagedAtTheStartIsSetAsideAndANewOneBegun) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 1);
  ASSERT_TRUE(published(1)) << daemon.log();
  ASSERT_EQ(daemon.stop(), 0);
  damage(daemon.db());
  const std::string damaged = test::read_file(daemon.db());
  listener->status.reset();
  daemon.start();
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const std::string aside = daemon.db() + ".damaged-1";
  EXPECT_NE(daemon.log().find(aside), std::string::npos) << daemon.log();
  EXPECT_EQ(test::read_file(aside), damaged) << "nothing of it is changed";
  EXPECT_TRUE(listener->until([&] { return !listener->alarms.empty(); }, test::kPatienceS)) << daemon.log();
  EXPECT_EQ(listener->alarms.at(0).rule, "ballbard_database");
  EXPECT_EQ(listener->alarms.at(0).severity, "critical");
  send(2, 3);
  EXPECT_TRUE(published(3)) << daemon.log();
  ASSERT_TRUE(listener->until([&] { return listener->status.has_value(); }, test::kPatienceS))
      << daemon.log();
  EXPECT_NE(listener->status->last_error.find("ballbar db recover"), std::string::npos);
  EXPECT_EQ(listener->status->alarms_firing, 1);
  daemon.process().signal(SIGHUP);  // other rules do not end it
  EXPECT_TRUE(daemon.says("configuration read again")) << daemon.log();
  send(4, 4);
  EXPECT_TRUE(published(4)) << daemon.log();
  for (const alarm_t& alarm : listener->alarms) EXPECT_EQ(alarm.state, "firing") << alarm.rule;
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 2, 4);
}

TEST_F(Fault, ADatabaseThatIsDamagedWhileTheServiceRunsCostsNoRunThatComesLater) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 1);
  ASSERT_TRUE(published(1)) << daemon.log();
  {  // another writer, so that the service reads its pages again
    Database other(daemon.db(), Database::Mode::kReadWrite, 1000);
    other.integer("PRAGMA wal_checkpoint(TRUNCATE)");
    other.execute("CREATE TABLE other (n)");
    damage(daemon.db());
    other.set_checkpoint_on_close(false);
  }
  send(2, 3);
  EXPECT_TRUE(published(3)) << daemon.log();
  EXPECT_TRUE(std::filesystem::exists(daemon.db() + ".damaged-1")) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 2, 3);
}

TEST_F(Fault, DamageThatRetentionMeetsIsTheSameAlarmAndWhoIsToldOfAlarmsGoesOnBeingTold) {
  const std::string told = dir.path() + "/told";
  test::write_file(dir.path() + "/tell", "#!/bin/sh\ncat >> " + told + "\n");
  std::filesystem::permissions(dir.path() + "/tell", std::filesystem::perms::owner_all);
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const auto configure = [&](const std::string& store) {
    daemon.configure("[notify]\ncommand = [\"" + dir.path() + "/tell\"]\nretry_s = 0.1\n" +
                     test::planar_robot(dir.path()));
    std::string text = test::read_file(daemon.config());
    text.insert(text.find("[rules]"), store);
    test::write_file(daemon.config(), text);
    daemon.process().signal(SIGHUP);
  };
  const auto is_told = [&](const std::string& text) {
    return listener->until([&] { return test::read_file(told).find(text) != std::string::npos; },
                           test::kPatienceS);
  };
  configure("");
  send(1, 1);
  ASSERT_TRUE(published(1)) << daemon.log();
  test::write_file(daemon.rules() + "/broken.lua", "no rule");
  configure("");
  ASSERT_TRUE(is_told("firing (warning) ballbard_rules")) << daemon.log();
  {
    Database other(daemon.db(), Database::Mode::kReadWrite, 1000);
    other.integer("PRAGMA wal_checkpoint(TRUNCATE)");
    other.execute("CREATE TABLE other (n)");
    damage(daemon.db());
    other.set_checkpoint_on_close(false);
  }
  configure("keep_days = 30\n");  // no run comes: retention alone reads
  EXPECT_TRUE(listener->until(
      [&] {
        return std::any_of(listener->alarms.begin(), listener->alarms.end(),
                           [](const alarm_t& alarm) { return alarm.rule == "ballbard_database"; });
      },
      test::kPatienceS))
      << daemon.log();
  EXPECT_TRUE(std::filesystem::exists(daemon.db() + ".damaged-1")) << daemon.log();
  std::filesystem::remove(daemon.rules() + "/broken.lua");
  configure("keep_days = 30\n");
  EXPECT_TRUE(is_told("resolved (warning) ballbard_rules")) << daemon.log();
  send(2, 2);
  EXPECT_TRUE(published(2)) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 2, 2);
}

TEST_F(Fault, ABackupThatIsMadeWhileItRunsIsSoundAndRestored) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const std::string copy = dir.path() + "/copy.db";
  const auto db = [&](const std::vector<std::string>& words) {
    std::vector<std::string> command{test::kBallbar, "db"};
    command.insert(command.end(), words.begin(), words.end());
    command.insert(command.end(), {"--config", daemon.config()});
    return test::run(command);
  };
  send(1, 2);
  ASSERT_TRUE(published(2)) << daemon.log();
  const test::Outcome made = db({"backup", copy});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("2 runs, checked"), std::string::npos) << made.out;
  EXPECT_EQ(db({"backup", copy}).code, 3) << "a file that is there is not written over";
  send(3, 3);
  ASSERT_TRUE(published(3)) << daemon.log();
  ASSERT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 3);
  EXPECT_EQ(db({"restore", copy}).code, 0);
  expect_all_ok(daemon.db(), 1, 2);
  expect_all_ok(daemon.db() + ".before-restore-1", 1, 3);
  EXPECT_EQ(db({"check"}).code, 0);
  damage(daemon.db());
  EXPECT_EQ(db({"check"}).code, 1);
}

/// Garbage over the index of runs by time: the service sees it at the start, and no run needs it.
void damage_index(const std::string& db) {
  std::streamoff page = 0;
  {
    Store store(db);
    page = store.database().integer("SELECT rootpage FROM sqlite_schema WHERE name = 'run_time'");
  }
  std::fstream file(db, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp((page - 1) * 4096);
  file << std::string(4096, '\x7f');
}

TEST_F(Fault, WhatIsRecoveredOfADamagedDatabaseIsBackAndTheAlarmEnds) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 2);
  ASSERT_TRUE(published(2)) << daemon.log();
  ASSERT_EQ(daemon.stop(), 0);
  damage_index(daemon.db());
  daemon.start();
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(3, 3);
  ASSERT_TRUE(published(3)) << daemon.log();
  ASSERT_TRUE(listener->until([&] { return !listener->alarms.empty(); }, test::kPatienceS)) << daemon.log();
  listener->alarms.clear();

  const std::string aside = daemon.db() + ".damaged-1";
  const test::Outcome outcome =
      test::run({test::kBallbar, "db", "recover", aside, "--config", daemon.config()});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("2 runs recovered, 2 with their recording; 0 runs"), std::string::npos)
      << outcome.out;
  EXPECT_FALSE(std::filesystem::exists(aside));
  EXPECT_TRUE(std::filesystem::exists(aside + ".recovered-1"));
  EXPECT_TRUE(listener->until(
      [&] { return !listener->alarms.empty() && listener->alarms.back().state == "resolved"; },
      test::kPatienceS))
      << daemon.log();
  listener->status.reset();
  ASSERT_TRUE(listener->until([&] { return listener->status.has_value(); }, test::kPatienceS))
      << daemon.log();
  EXPECT_EQ(listener->status->alarms_firing, 0);
  EXPECT_EQ(listener->status->last_error, "");
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 3);
}

TEST_F(Fault, ADamagedDatabaseThatHoldsNothingMoreStaysAndTheToolSaysSo) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  ASSERT_EQ(daemon.stop(), 0);
  const std::string aside = daemon.db() + ".damaged-1";
  std::filesystem::copy_file(daemon.db(), aside);
  damage(aside);
  const test::Outcome outcome =
      test::run({test::kBallbar, "db", "recover", aside, "--config", daemon.config()});
  EXPECT_EQ(outcome.code, 3) << outcome.out;
  EXPECT_NE(outcome.err.find(aside + ": nothing of it can be read"), std::string::npos) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(aside));
}

}  // namespace
}  // namespace ballbar

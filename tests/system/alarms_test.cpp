// Alarms that people answer and are told of: a real daemon, the real tool, real commands. The alarm that they
// are about is the daemon's own, of rules that cannot be taken: it needs no robot.

#include <gtest/gtest.h>
#include <pwd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "support/live_daemon.hpp"

namespace ballbar {
namespace {

using nlohmann::json;
using test::LiveDaemon;
using test::Outcome;

using test::kPatienceS;

/// Looks every 50 ms. @return done
bool until(const std::function<bool()>& done) {
  for (int i = 0; i < 20 * kPatienceS; ++i) {
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return done();
}

std::string rule(const std::string& name) {
  return "return { name = '" + name +
         "', on = 'circle', when = function(result) return false end, text = 't' }\n";
}

class LiveAlarms : public testing::Test {
 protected:
  void SetUp() override {
    const std::string failure = test::enter_private_network();
    ASSERT_EQ(failure, "") << "these tests need a network namespace (root, or user namespaces allowed)";
  }

  static void reload(LiveDaemon& daemon) {
    daemon.process().signal(SIGHUP);
    ASSERT_TRUE(daemon.notify().until("RELOADING=1", kPatienceS));
    ASSERT_TRUE(daemon.notify().until("READY=1", kPatienceS));
  }
  static void break_rules(LiveDaemon& daemon) {
    test::write_file(daemon.rules() + "/broken.lua", "return {\n  name = 'half writ");
    reload(daemon);
  }
  static void mend_rules(LiveDaemon& daemon) {
    std::filesystem::remove(daemon.rules() + "/broken.lua");
    reload(daemon);
  }
  static Outcome alarms(const LiveDaemon& daemon, std::vector<std::string> words) {
    words.insert(words.begin(), {test::kBallbar, "alarms"});
    words.insert(words.end(), {"--config", daemon.config()});
    return test::run(words);
  }
  static json listed(const LiveDaemon& daemon) {
    return json::parse(alarms(daemon, {"--all", "--json"}).out)["alarms"];
  }
  /// The state of the daemon's own alarm; "" where it was never raised.
  static std::string state_of(const LiveDaemon& daemon, const std::string& rule) {
    for (const json& alarm : listed(daemon))
      if (alarm["rule"] == rule) return alarm["state"];
    return "";
  }
  static void write_script(const std::string& path, const std::string& body) {
    test::write_file(path + ".new", "#!/bin/sh\n" + body);
    chmod((path + ".new").c_str(), 0755);
    std::filesystem::rename(path + ".new", path);
  }
};

TEST_F(LiveAlarms, WhoAcknowledgesOrShelvesIsOnRecordAndSurvivesARestart) {
  LiveDaemon daemon("");
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  test::Listener listener;
  break_rules(daemon);
  const Outcome ack = alarms(daemon, {"ack", "1", "--comment", "seen; half a file", "--name", "Anna Ü"});
  ASSERT_EQ(ack.code, 0) << ack.err << daemon.log();
  const Outcome shelve = alarms(daemon, {"shelve", "1", "--for", "8h", "--comment", "repair"});
  ASSERT_EQ(shelve.code, 0) << shelve.err;
  const passwd* me = getpwuid(getuid());
  const std::string by =
      std::string("Anna Ü (") + (me ? me->pw_name : "uid " + std::to_string(getuid())) + ")";
  EXPECT_TRUE(listener.until(
      [&] { return !listener.alarms.empty() && !listener.alarms.back().shelved_by.empty(); }, kPatienceS));
  EXPECT_EQ(listener.alarms.back().acknowledged_by, by);
  EXPECT_EQ(listener.alarms.back().acknowledged_comment, "seen; half a file");
  EXPECT_EQ(listener.alarms.back().state, "firing");
  ASSERT_EQ(daemon.stop(), 0);

  const json before = listed(daemon);
  ASSERT_EQ(before.size(), 1u);
  EXPECT_EQ(before[0]["acknowledged"]["by"], by);
  EXPECT_EQ(before[0]["shelved"]["comment"], "repair");
  daemon.start();
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  EXPECT_EQ(listed(daemon), before) << "the same rules, the same alarm, the same people";
  ASSERT_EQ(alarms(daemon, {"unshelve", "1"}).code, 0);
  const std::string shown = alarms(daemon, {"show", "1"}).out;
  for (const std::string& word :
       {std::string("ballbard_rules"), std::string("broken.lua:2:"), std::string("acknowledged by ") + by,
        std::string("inactive -> firing"), std::string("unshelved by ")})
    EXPECT_NE(shown.find(word), std::string::npos) << word << " is not in\n" << shown;
  mend_rules(daemon);
  EXPECT_EQ(state_of(daemon, "ballbard_rules"), "resolved");
  break_rules(daemon);
  EXPECT_TRUE(listed(daemon)[0]["acknowledged"].is_null()) << "fires anew: nobody has seen that";
  EXPECT_EQ(daemon.stop(), 0);
}

TEST_F(LiveAlarms, WhatMakesNoSenseIsRefusedInOneLine) {
  LiveDaemon daemon("");
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  break_rules(daemon);
  mend_rules(daemon);
  struct Case {
    std::vector<std::string> words;
    int code;
    std::string says;
  };
  const std::vector<Case> cases{
      {{"ack", "99"}, 2, "no alarm has the id 99"},
      {{"ack", "1"}, 2, "is resolved; only one that fires can be acknowledged"},
      {{"unshelve", "1"}, 2, "is not shelved"},
      {{"shelve", "1"}, 2, "say until when"},
      {{"shelve", "1", "--for", "8 parsecs"}, 2, "--for takes minutes, hours or days"},
      {{"shelve", "1", "--for", "-1h"}, 2, "--for takes minutes, hours or days"},
      {{"shelve", "1", "--until", "tomorrow"}, 2, "'tomorrow' is no time"},
      {{"shelve", "1", "--until", "2001-01-01 08:00"}, 2, "until a time to come"},
      {{"shelve", "1", "--for", "400d"}, 2, "at most 366 days"},
      {{"ack", "1", "--comment", std::string(1001, 'x')}, 2, "'comment' is longer than 1000 bytes"},
      {{"ack", "1", "--socket", daemon.path("nobody")}, 3, "does ballbard run"},
      {{"ack", "1", "--socket", "/" + std::string(120, 'x')}, 2, "longer than the 107 bytes"},
      {{"show", "99"}, 2, "no alarm 99"},
  };
  for (const Case& c : cases) {
    const Outcome outcome = alarms(daemon, c.words);
    EXPECT_EQ(outcome.code, c.code) << c.says << "\n" << outcome.err;
    EXPECT_NE(outcome.err.find(c.says), std::string::npos) << c.says << "\n" << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  EXPECT_EQ(daemon.stop(), 0);
  EXPECT_FALSE(std::filesystem::exists(daemon.control()));
  EXPECT_EQ(alarms(daemon, {"ack", "1"}).code, 3);
}

/// A connection that says `request`. @return the answer; "" where there is none
std::string say(const std::string& path, const std::string& request) {
  const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  std::string answer(8192, '\0');
  ssize_t size = -1;
  if (connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) {
    if (send(fd, request.data(), request.size(), MSG_NOSIGNAL) >= 0)
      size = recv(fd, answer.data(), answer.size(), 0);
  }
  close(fd);
  answer.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return answer;
}

TEST_F(LiveAlarms, TheSocketBearsWhateverIsSaidToItAndThoseWhoSayNothing) {
  LiveDaemon daemon("");
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  struct stat made {};
  ASSERT_EQ(stat(daemon.control().c_str(), &made), 0);
  EXPECT_EQ(made.st_mode & 0777U, 0660U) << "owner and group, nobody else";
  std::vector<int> silent;
  for (int i = 0; i < 30; ++i) {
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    daemon.control().copy(address.sun_path, sizeof address.sun_path - 1);
    if (connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) silent.push_back(fd);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(silent.size(), 30u);
  std::string deep = R"({"verb": )" + std::string(2000, '[') + std::string(2000, ']') + "}";
  for (const std::string& request :
       {std::string("x"), std::string("[]"), std::string("null"), std::string("{"), std::string(4097, ' '),
        std::string(R"({"verb": "acknowledge"})"), std::string(R"({"verb": 3, "alarm": 1})"),
        std::string(R"({"verb": "acknowledge", "alarm": 1e99})"),
        std::string(R"({"verb": "acknowledge", "alarm": -9223372036854775808})"),
        std::string(R"({"verb": "shelve", "alarm": 1, "until_us": 9223372036854775807})"),
        std::string(R"({"verb": "drop", "alarm": 1})"), std::string("\0\xff\xfe{}", 5), deep}) {
    const json answer = json::parse(say(daemon.control(), request), nullptr, false);
    EXPECT_TRUE(answer.is_object() && answer.contains("error")) << request.substr(0, 80) << daemon.log();
  }
  for (const int fd : silent) close(fd);
  break_rules(daemon);
  EXPECT_EQ(say(daemon.control(), R"({"verb": "acknowledge", "alarm": 1, "comment": "a\nb"})"),
            "{\"ok\":true}\n");
  EXPECT_EQ(listed(daemon)[0]["acknowledged"]["comment"], "a b");
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
}

TEST_F(LiveAlarms, TheCommandIsToldOnceOfEachAlarmAndNotOfShelvedOnes) {
  LiveDaemon daemon("");
  ASSERT_TRUE(daemon.ready());
  const std::string script = daemon.path("tell"), told = daemon.path("told");
  write_script(script, "cat >> " + told + "\n");
  break_rules(daemon);  // before there is a command: not told
  daemon.configure("[notify]\ncommand = [\"" + script + "\"]\nretry_s = 0.1\n");
  mend_rules(daemon);  // with this reload there is one
  EXPECT_TRUE(until([&] {
    return test::read_file(told).find("resolved (warning) ballbard_rules") != std::string::npos;
  })) << daemon.log();
  ASSERT_EQ(alarms(daemon, {"shelve", "1", "--for", "1h"}).code, 0);
  break_rules(daemon);
  mend_rules(daemon);
  ASSERT_EQ(alarms(daemon, {"unshelve", "1"}).code, 0);
  break_rules(daemon);
  EXPECT_TRUE(until([&] {
    return test::read_file(told).find("firing (warning) ballbard_rules") != std::string::npos;
  })) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0);
  std::vector<json> events;
  std::istringstream text(test::read_file(told));
  for (json event; text >> std::ws && !text.eof();) {
    text >> event;
    events.push_back(event);
  }
  ASSERT_EQ(events.size(), 2u) << test::read_file(told) << daemon.log();
  const json& event = events[1];
  EXPECT_EQ(event["version"], 1);
  EXPECT_EQ(event["to"], "firing");
  EXPECT_EQ(event["alarm"]["id"], 1);
  EXPECT_EQ(event["alarm"]["rule"], "ballbard_rules");
  EXPECT_EQ(event["subject"], "ballbard: firing (warning) ballbard_rules");
  EXPECT_NE(event["message"].get<std::string>().find("broken.lua:2:"), std::string::npos);
  EXPECT_GT(event["event"], events[0]["event"]);
}

TEST_F(LiveAlarms, ACommandThatHangsOrFailsHoldsNothingUpAndIsAnAlarmOfItsOwn) {
  LiveDaemon daemon("");
  const std::string script = daemon.path("tell"), told = daemon.path("told");
  ASSERT_TRUE(daemon.ready());
  // It leaves a child behind that holds its files open: that ends with it.
  write_script(script, "sleep 1000 & echo $! >> " + daemon.path("children") + "; sleep 1000\n");
  daemon.configure("[notify]\ncommand = [\"" + script + "\"]\ntime_limit_s = 0.3\nretry_s = 0.1\n");
  reload(daemon);
  break_rules(daemon);
  EXPECT_TRUE(until([&] { return state_of(daemon, "ballbard_notify") == "firing"; })) << daemon.log();
  EXPECT_NE(alarms(daemon, {}).out.find("took longer than its time limit"), std::string::npos);
  test::Listener listener;
  EXPECT_TRUE(listener.until([&] { return listener.status.has_value(); }, kPatienceS))
      << "it goes on as ever";
  std::istringstream children(test::read_file(daemon.path("children")));
  pid_t first = 0;
  ASSERT_TRUE(children >> first);
  EXPECT_TRUE(until([&] {
    const std::string stat = test::read_file("/proc/" + std::to_string(first) + "/stat");
    return stat.empty() || stat.find(") Z") != std::string::npos;
  })) << "a child of the command outlives its time";
  ASSERT_EQ(daemon.stop(), 0) << daemon.log();

  write_script(script, "exit 7\n");
  daemon.start();
  ASSERT_TRUE(daemon.ready());
  EXPECT_TRUE(until([&] { return daemon.log().find("ended with exit code 7") != std::string::npos; }))
      << "what was not told is tried again after a restart\n"
      << daemon.log();
  write_script(script, "cat >> " + told + "\n");
  EXPECT_TRUE(until([&] { return state_of(daemon, "ballbard_notify") == "resolved"; })) << daemon.log();
  EXPECT_NE(test::read_file(told).find("firing (warning) ballbard_rules"), std::string::npos);
  EXPECT_EQ(test::read_file(told).find("ballbard_notify\""), std::string::npos)
      << "its own failure is not told by it";
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
}

TEST_F(LiveAlarms, TheLastGoodSetOfRulesStaysWhateverBecomesOfTheFolder) {
  LiveDaemon daemon("");
  ASSERT_TRUE(daemon.ready());
  const auto in_use = [&](int rules, int generation) {
    const std::string says =
        ", " + std::to_string(rules) + " rules of generation " + std::to_string(generation) + ", ";
    return daemon.notify().until(says, kPatienceS) ? "" : "no STATUS with" + says + "\n" + daemon.log();
  };
  const auto restart = [&] {
    ASSERT_EQ(daemon.stop(), 0);
    daemon.start();
    ASSERT_TRUE(daemon.ready()) << daemon.log();
  };
  EXPECT_EQ(in_use(0, 1), "") << "an empty folder is a set";
  test::write_file(daemon.rules() + "/a.lua", rule("a"));
  test::write_file(daemon.rules() + "/b.lua", rule("b"));
  reload(daemon);
  EXPECT_EQ(in_use(2, 2), "");
  test::write_file(daemon.rules() + "/c.lua", rule("c"));
  break_rules(daemon);
  EXPECT_EQ(in_use(2, 2), "") << "not the good half of a bad set";
  EXPECT_NE(daemon.log().find("rules generation 2 stays: broken.lua:2:"), std::string::npos) << daemon.log();
  restart();
  EXPECT_EQ(in_use(2, 2), "") << "a restart does not change that\n" << daemon.log();
  EXPECT_EQ(state_of(daemon, "ballbard_rules"), "firing");
  mend_rules(daemon);
  EXPECT_EQ(in_use(3, 3), "");
  std::filesystem::remove(daemon.rules() + "/c.lua");
  reload(daemon);
  EXPECT_EQ(in_use(2, 4), "");
  std::filesystem::create_symlink("nowhere", daemon.rules() + "/c.lua");
  reload(daemon);
  EXPECT_EQ(in_use(2, 4), "") << "a file that cannot be read";
  std::filesystem::remove(daemon.rules() + "/c.lua");
  ASSERT_EQ(mkfifo((daemon.rules() + "/c.lua").c_str(), 0600), 0);
  reload(daemon);
  EXPECT_EQ(in_use(2, 4), "") << "a pipe that nobody writes";
  EXPECT_NE(daemon.log().find("c.lua: not a file that can be read"), std::string::npos) << daemon.log();
  std::filesystem::remove(daemon.rules() + "/c.lua");
  if (geteuid() != 0) {  // root may read everything
    std::filesystem::permissions(daemon.rules(), std::filesystem::perms::none);
    reload(daemon);
    EXPECT_EQ(in_use(2, 4), "") << "a folder that must not be read";
    std::filesystem::permissions(daemon.rules(), std::filesystem::perms::owner_all);
  }
  std::filesystem::remove_all(daemon.rules());
  reload(daemon);
  EXPECT_EQ(in_use(2, 4), "") << "a folder that is gone";
  EXPECT_NE(alarms(daemon, {}).out.find("cannot read the folder"), std::string::npos);
  restart();
  EXPECT_EQ(in_use(2, 4), "") << daemon.log();
  test::write_file(daemon.rules(), "no folder at all");
  reload(daemon);
  EXPECT_EQ(in_use(2, 4), "");
  std::filesystem::remove(daemon.rules());
  std::filesystem::create_directory(daemon.rules());
  test::write_file(daemon.rules() + "/a.lua", rule("a"));
  test::write_file(daemon.rules() + "/b.lua", rule("b"));
  reload(daemon);
  EXPECT_EQ(in_use(2, 4), "") << "the same set has the same number";
  EXPECT_EQ(state_of(daemon, "ballbard_rules"), "resolved");
  std::filesystem::remove(daemon.rules() + "/a.lua");
  reload(daemon);
  EXPECT_EQ(in_use(1, 5), "");
  EXPECT_EQ(daemon.stop(), 0);
}

}  // namespace
}  // namespace ballbar

// What we publish, decoded by the generated Java classes as lcm-spy uses them, against what is stored.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "bus/publisher.hpp"
#include "store/store.hpp"
#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

using nlohmann::json;

const std::string kDemo = BALLBAR_SOURCE_DIR "/scripts/demo.lcm";

std::string sink(const std::string& log) { return "file://" + log + "?mode=w"; }

/// Every message of the log as Java sees it, in sequence.
std::vector<json> decode_in_java(const std::string& log) {
  const test::Outcome outcome =
      test::run({BALLBAR_JAVA, "-cp", BALLBAR_DECODE_JAR ":" BALLBAR_TYPES_JAR ":" BALLBAR_LCM_JAR,
                 "DecodeResults", log});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  std::vector<json> messages;
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line);) messages.push_back(json::parse(line));
  return messages;
}

std::vector<json> of_channel(const std::vector<json>& messages, const std::string& channel) {
  std::vector<json> found;
  for (const json& message : messages)
    if (message["channel"] == channel) found.push_back(message);
  return found;
}

/// The same number in both, to the last bit; "NaN" in Java where the JSON has null.
void expect_same(const json& java, const json& stored, const std::string& name) {
  if (stored.is_null())
    EXPECT_EQ(java, "NaN") << name;
  else
    EXPECT_EQ(java, stored) << name;
}

/// Column `name` of a list of objects.
json column(const json& list, const std::string& name) {
  json values = json::array();
  for (const json& entry : list) values.push_back(entry.at(name).is_null() ? json("NaN") : entry.at(name));
  return values;
}

/// A replay of the shipped recording: what it published, and what it stored.
class ReplayOnTheWire : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const test::TempDir dir;
    const std::string db = dir.path() + "/a.db", log = dir.path() + "/results.lcm",
                      config = dir.path() + "/c.toml";
    std::string text = test::read_file(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.toml");
    text.replace(text.find("\"lrmate200ic"), 1, "\"" BALLBAR_SOURCE_DIR "/scripts/robots/");
    test::write_file(config, "[rules]\ndirectory = \"" BALLBAR_SOURCE_DIR "/scripts/rules\"\n" + text);
    const test::Outcome replay = test::run(
        {test::kBallbar, "replay", kDemo, "--config", config, "--db", db, "--publish", sink(log), "--quiet"});
    ASSERT_EQ(replay.code, 0) << replay.err;
    stored = json::parse(test::run({test::kBallbar, "export", "--json", "--db", db}).out)["runs"];
    changes = Store::open_read_only(db).events();
    heard = decode_in_java(log);
  }
  static std::vector<json> stored_of(const std::string& kind) {
    std::vector<json> found;
    for (const json& run : stored)
      if (run["kind"] == kind) found.push_back(run);
    return found;
  }
  /// Labels and conditions that circles and lines share.
  static void expect_common(const json& java, const json& run, std::size_t seq) {
    EXPECT_EQ(java["seq"], seq);
    EXPECT_EQ(java["time_us"], run["ended_us"]);
    for (const char* name :
         {"robot", "test", "series", "status", "direction", "repetition", "started_us", "lost_messages",
          "feed_mm_s", "payload_kg", "temperature_c", "predicted_from", "gap_rms_um", "gap_largest_um"})
      expect_same(java.at(name), run.at(name), name);
  }

  static inline json stored;
  static inline std::vector<StoredEvent> changes;
  static inline std::vector<json> heard;
};

TEST_F(ReplayOnTheWire, EveryCircleIsInJavaWhatIsStored) {
  const std::vector<json> java = of_channel(heard, "CIRCLE_RESULT"), runs = stored_of("circle");
  ASSERT_GT(runs.size(), 0u);
  ASSERT_EQ(java.size(), runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    SCOPED_TRACE(runs[i]["run"]);
    expect_common(java[i], runs[i], i + 1);
    for (const char* name : {"angle_source",
                             "source",
                             "samples",
                             "mean_radius_deviation_um",
                             "eccentricity_um",
                             "eccentricity_deg",
                             "ovality_um",
                             "ovality_axis_deg",
                             "circular_deviation_um",
                             "circular_deviation_mz_um",
                             "radial_max_um",
                             "radial_min_um",
                             "noise_um",
                             "gap_mean_um",
                             "gap_largest_deg",
                             "plane",
                             "filter_upr",
                             "start_angle_deg",
                             "end_angle_deg",
                             "circular_error_um",
                             "radial_max_setup_um",
                             "radial_min_setup_um",
                             "roundness_lsc_um",
                             "roundness_mzc_um",
                             "roundness_mic_um",
                             "roundness_mcc_um",
                             "circular_error_bidirectional_um",
                             "mean_bidirectional_radial_error_um",
                             "hysteresis_um",
                             "hysteresis_deg"})
      expect_same(java[i].at(name), runs[i].at(name), name);
    EXPECT_EQ(java[i]["orders"], runs[i]["harmonics"].size());
    for (const char* name : {"cos_um", "sin_um"})
      EXPECT_EQ(java[i].at(name), column(runs[i]["harmonics"], name)) << name;
    // Not stored but made from the stored covariance, which is in other units: the last digit may be rounded
    // otherwise.
    for (std::size_t k = 0; k < runs[i]["harmonics"].size(); ++k)
      EXPECT_DOUBLE_EQ(java[i]["sd_um"][k].get<double>(), runs[i]["harmonics"][k]["sd_um"].get<double>())
          << "order " << k + 1;
    EXPECT_EQ(java[i]["sd_um"].size(), runs[i]["harmonics"].size());
    EXPECT_EQ(java[i]["predicted_from"], "joints");
    EXPECT_EQ(java[i]["gap_orders"], 10);
    for (const char* name : {"cos_um", "sin_um"})
      EXPECT_EQ(java[i].at(std::string("gap_") + name), column(runs[i]["gap_harmonics"], name)) << name;
    EXPECT_EQ(java[i].size(), 54u) << "a field that is compared with nothing";
  }
}

TEST_F(ReplayOnTheWire, EveryLineIsInJavaWhatIsStored) {
  const std::vector<json> java = of_channel(heard, "LINE_RESULT"), runs = stored_of("line");
  ASSERT_GT(runs.size(), 0u);
  ASSERT_EQ(java.size(), runs.size());
  bool reversal = false;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    SCOPED_TRACE(runs[i]["run"]);
    expect_common(java[i], runs[i], i + 1);
    for (const char* name : {"axis", "straightness_mz_um", "straightness_ls_um", "straightness_ep_um",
                             "reversal_max_um", "gap_largest_mm", "points"})
      expect_same(java[i].at(name), runs[i].at(name), name);
    for (const char* name : {"position_mm", "deviation_um", "reversal_um", "predicted_um"})
      EXPECT_EQ(java[i].at(name), column(runs[i]["profile"], name)) << name;
    reversal = reversal || java[i]["reversal_max_um"].is_number();
    EXPECT_EQ(java[i].size(), 28u) << "a field that is compared with nothing";
  }
  EXPECT_TRUE(reversal) << "the recording has lines both ways";
}

json column_of(const AlarmStatus& alarm, const std::function<json(const AlarmNumber&)>& field) {
  json column = json::array();
  for (const AlarmNumber& number : alarm.numbers) column.push_back(field(number));
  return column;
}

TEST_F(ReplayOnTheWire, EveryChangeOfAnAlarmIsInJavaWhatIsStored) {
  const std::vector<json> java = of_channel(heard, "ALARM");
  ASSERT_EQ(java.size(), changes.size());
  bool fired = false;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const AlarmStatus& alarm = changes[i].event.status;
    EXPECT_EQ(
        java[i],
        (json{{"channel", "ALARM"},
              {"time_us", alarm.judged_us},
              {"seq", i + 1},
              {"rule", alarm.key.rule},
              {"robot", alarm.key.robot},
              {"test", alarm.key.test},
              {"axis", alarm.key.axis},
              {"direction", alarm.key.direction},
              {"state", to_string(alarm.state)},
              {"severity", alarm.severity},
              {"since_us", alarm.since_us},
              {"bad_runs", alarm.bad_runs},
              {"text", alarm.text},
              {"id", alarm.id},
              {"clean_runs", alarm.clean_runs},
              {"flapping", alarm.flapping},
              {"acknowledged_by", ""},
              {"acknowledged_comment", ""},
              {"acknowledged_us", 0},
              {"shelved_by", ""},
              {"shelved_comment", ""},
              {"shelved_until_us", 0},
              {"numbers", alarm.numbers.size()},
              {"number_name", column_of(alarm, [](const AlarmNumber& n) { return json(n.name); })},
              {"number_value", java[i]["number_value"]},
              {"number_sd", java[i]["number_sd"]},
              {"number_of_rule", column_of(alarm, [](const AlarmNumber& n) { return json(n.of_rule); })},
              {"runs", alarm.runs.size()},
              {"run_started_us", alarm.runs}}));
    for (std::size_t k = 0; k < alarm.numbers.size(); ++k) {  // stored to twelve digits
      EXPECT_NEAR(java[i]["number_value"][k].get<double>(), alarm.numbers[k].value,
                  1e-11 * std::abs(alarm.numbers[k].value));
      EXPECT_EQ(java[i]["number_sd"][k].is_number(), alarm.numbers[k].sd.has_value());
    }
    fired = fired || alarm.state == AlarmState::kFiring;
  }
  EXPECT_TRUE(fired) << "the recording drifts until an alarm fires";
}

DaemonStatus full_status() {
  DaemonStatus s;
  s.time_us = 1'700'000'000'000'001;
  s.version = "9.8.7";
  s.state = "waiting for the network";
  s.database = "/var/lib/ballbard/\"quoted\" \\ back.db";
  s.last_error = "no space";
  s.messages = 5'000'000'000;  // more than 32 bits hold
  s.refused = 102;
  s.lost_messages = 103;
  s.kernel_drops = 104;
  s.receiver_restarts = 105;
  s.runs_stored = 106;
  s.runs_ok = 107;
  s.runs_open = 108;
  s.store_failures = 109;
  s.runs_waiting = 110;
  s.rules = 111;
  s.rules_generation = 112;
  s.rule_errors = 113;
  s.alarms_firing = 114;
  return s;
}

TEST(PublisherOnTheWire, EveryFieldOfTheStatusArrivesInJava) {
  const test::TempDir dir;
  const std::string log = dir.path() + "/status.lcm";
  {
    Publisher publisher(sink(log));
    publisher.publish(full_status());
    publisher.publish(DaemonStatus{});
  }
  const std::vector<json> java = decode_in_java(log);
  ASSERT_EQ(java.size(), 2u);
  EXPECT_EQ(
      java[0],
      json::parse(R"({"channel": "BALLBARD_STATUS", "time_us": 1700000000000001, "seq": 1, "version": "9.8.7",
    "state": "waiting for the network", "messages": 5000000000, "refused": 102, "lost_messages": 103, "kernel_drops": 104,
    "receiver_restarts": 105, "runs_stored": 106, "runs_ok": 107, "runs_open": 108, "store_failures": 109, "runs_waiting": 110,
    "rules": 111, "rules_generation": 112, "rule_errors": 113, "alarms_firing": 114,
    "database": "/var/lib/ballbard/\"quoted\" \\ back.db", "last_error": "no space"})"));
  EXPECT_EQ(java[1]["seq"], 2);
  EXPECT_EQ(java[1]["last_error"], "");
}

TEST(PublisherOnTheWire, EveryFieldOfAnAlarmArrivesInJavaWithQuotesAndUmlauts) {
  const test::TempDir dir;
  const std::string log = dir.path() + "/alarm.lcm";
  {
    AlarmStatus alarm;
    alarm.key = {"ovality_high", "lrmate-1", "Y", -1, "Z"};
    alarm.state = AlarmState::kResolved;
    alarm.severity = "critical";
    alarm.since_us = 1'700'000'000'000'000;
    alarm.judged_us = 1'700'000'000'000'002;
    alarm.bad_runs = 7;
    alarm.text = "test \"Y\" \\ über 150 µm\nsecond line";
    alarm.id = 5'000'000'000;
    alarm.clean_runs = 4;
    alarm.flapping = true;
    alarm.numbers = {{"ovality_um", 31.25, 0.5, false}, {"limit_um", 25.0, {}, true}};
    alarm.runs = {1'700'000'000'000'003, 1'700'000'000'000'004};
    alarm.acknowledged = {"anna", "seen \"it\"", 1'700'000'000'000'005};
    alarm.shelved = {"bo", "später", 1'700'000'000'000'006};
    Publisher(sink(log)).publish(alarm);
  }
  const std::vector<json> java = decode_in_java(log);
  ASSERT_EQ(java.size(), 1u);
  EXPECT_EQ(java[0],
            json::parse(R"({"channel": "ALARM", "time_us": 1700000000000002, "seq": 1, "rule": "ovality_high",
    "robot": "lrmate-1", "test": "Y", "axis": "Z", "direction": -1, "state": "resolved", "severity": "critical",
    "since_us": 1700000000000000, "bad_runs": 7, "text": "test \"Y\" \\ über 150 µm\nsecond line",
    "id": 5000000000, "clean_runs": 4, "flapping": true, "acknowledged_by": "anna",
    "acknowledged_comment": "seen \"it\"", "acknowledged_us": 1700000000000005, "shelved_by": "bo",
    "shelved_comment": "später", "shelved_until_us": 1700000000000006, "numbers": 2,
    "number_name": ["ovality_um", "limit_um"], "number_value": [31.25, 25.0], "number_sd": [0.5, "NaN"],
    "number_of_rule": [false, true], "runs": 2, "run_started_us": [1700000000000003, 1700000000000004]})"));
}

TEST(PublisherOnTheWire, FiguresThatARunDoesNotGiveAreNaNInJava) {
  const test::TempDir dir;
  const std::string log = dir.path() + "/nan.lcm";
  ballbar::Run run;
  run.kind = TestKind::kCircle;
  Record record;
  record.robot = "r1";
  record.status = "arc_incomplete";
  record.values["noise_um"] = {std::nextafter(0.1, 1.0), {}};
  Publisher(sink(log)).publish(run, RunResult{}, {record});
  const std::vector<json> java = decode_in_java(log);
  ASSERT_EQ(java.size(), 1u);
  EXPECT_EQ(java[0]["status"], "arc_incomplete");
  EXPECT_EQ(java[0]["ovality_um"], "NaN");
  EXPECT_EQ(java[0]["noise_um"], std::nextafter(0.1, 1.0)) << "to the last bit";
  EXPECT_EQ(java[0]["orders"], 0);
  EXPECT_EQ(java[0]["cos_um"], json::array());
}

}  // namespace
}  // namespace ballbar

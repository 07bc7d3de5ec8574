// The configuration file: what it means in SI units, and where and why a wrong one is refused.

#include "daemon/config.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/error.hpp"
#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;

class ConfigFile : public testing::Test {
 protected:
  void SetUp() override { test::write_file(dir.path() + "/r.urdf", "<robot name=\"r\"/>"); }

  std::string path() const { return dir.path() + "/ballbard.toml"; }
  Config load(const std::string& text) const {
    test::write_file(path(), text);
    return load_config(path());
  }
  /// What load_config says of `text`, without the path before it; empty where it is content.
  std::string complaint(const std::string& text) const {
    try {
      load(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.cause(), Cause::kInput);
      const std::string what = error.what();
      EXPECT_EQ(what.find('\n'), std::string::npos) << "an error is one line: " << what;
      EXPECT_TRUE(what.starts_with(path() + ":")) << what;
      return what.substr(path().size() + 1);
    }
    return "";
  }
  CircleSpec circle(const std::string& more) const {
    return load(kRobot + kCircle + more).robots.at(0).tests.at(0).circle;
  }

  // Four lines and six: what is appended begins at line 5, or at line 11.
  inline static const std::string kRobot = "\n[[robot]]\nname = \"r1\"\nurdf = \"r.urdf\"\n";
  inline static const std::string kCircle =
      "[[robot.test]]\nname = \"A\"\nkind = \"circle\"\ncentre_mm = [380, -320, -251]\nradius_mm = 100\n\n";
  inline static const std::string kLine =
      "[[robot.test]]\nname = \"Y\"\nkind = \"line\"\nstart_mm = [380, -470, -251]\nend_mm = [380, 470, "
      "-251]\n\n";
  test::TempDir dir;
};

void expect_vector(const Vec3& got, const Vec3& want) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(got[i], want[i], 1e-12) << "component " << i;
}

TEST_F(ConfigFile, AWrongOneIsRefusedWithLineColumnAndWhatIsWrong) {
  struct Row {
    std::string text, at, says;
  };
  const std::string many_a(101, 'a');
  const std::vector<Row> rows{
      // Not TOML.
      {"[bus\n", "1:5: ", ""},
      {"[bus]\nurl = udpm\n", "2:7: ", ""},
      {"[bus]\nurl = \"a\"\nurl = \"b\"\n", "3:", "url"},
      {"x = \"\xff\xfe\"\n", "1:", ""},

      // A key that nobody knows.
      {"robots = 1\n", "1:1: ",
       "unknown key 'robots' in the configuration; known are: bus, control, diagnosis, metrics, notify, "
       "robot, "
       "rules, store"},
      {"[bus]\nulr = \"udpm://\"\n", "2:1: ", "unknown key 'ulr' in [bus]; known are: url"},
      {"[store]\n  file = \"x\"\n",
       "2:3: ", "unknown key 'file' in [store]; known are: keep_days, keep_traces_days, max_size_mb, path"},
      {"[rules]\ndir = \"x\"\n", "2:1: ", "unknown key 'dir' in [rules]; known are: directory"},
      {kRobot + "payload = 3\n",
       "5:1: ", "unknown key 'payload' in [[robot]]; known are: base, effect, expansion_ppm_k, "},
      {kRobot + kCircle + "points = 51\n", "11:1: ", "unknown key 'points' in [[robot.test]]"},
      {kRobot + kCircle + "overshot_deg = 60\n",
       "11:1: ", "payload_kg, posture_deg, radius_mm, tool_rpy_deg"},
      {kRobot + kLine + "radius_mm = 100\n", "11:1: ", "unknown key 'radius_mm' in [[robot.test]]"},

      {"[notify]\ncommand = [\"/a\"]\nlimit_s = 3\n",
       "3:1: ", "unknown key 'limit_s' in [notify]; known are: command, retry_s, severity, time_limit_s"},

      // Another type.
      {"[notify]\ncommand = \"/bin/mail me\"\n", "2:11: ", "'command' is a list"},
      {"[notify]\ncommand = []\n", "2:11: ", "'command' is a list"},
      {"[notify]\ncommand = [\"/a\", 3]\n", "2:18: ", "each word of 'command' must be text in quotes"},
      {"[notify]\ncommand = [\"mail\"]\n", "2:11: ", "'command' begins with the whole path of a program"},
      {"[notify]\n", "1:1: ", "'command' is a list"},
      {"[notify]\ncommand = [\"/a\"]\ntime_limit_s = 0\n",
       "3:16: ", "'time_limit_s' = 0 is outside 0.1 .. 3600"},
      {"[notify]\ncommand = [\"/a\"]\nseverity = \"error\"\n", "3:12: ", "not \"error\""},
      {"bus = \"udpm://\"\n", "1:7: ", "write [bus] as a table"},
      {"[bus]\nurl = 7667\n", "2:7: ", "'url' must be text in quotes"},
      {"[[store]]\npath = \"x\"\n", "1:1: ", "write [store] as a table"},
      {"[robot]\nname = \"r1\"\n", "1:1: ", "write [[robot]] for each one"},
      {"\nrobot = [1, 2]\n", "2:9: ", "write [[robot]] for each one"},
      {"[[robot]]\nname = 1\n", "2:8: ", "'name' must be text in quotes"},
      {kRobot + "payload_kg = \"3\"\n", "5:14: ", "'payload_kg' must be a number"},
      {kRobot + "payload_kg = true\n", "5:14: ", "'payload_kg' must be a number"},
      {kRobot + "payload_kg = 2026-01-01\n", "5:14: ", "'payload_kg' must be a number"},
      {kRobot + "payload_kg = [3]\n", "5:14: ", "'payload_kg' must be a number"},
      {kRobot + "payload_com_mm = 50\n", "5:18: ", "'payload_com_mm' must be a list of numbers"},
      {kRobot + "gear_ratio = [120, \"121\"]\n", "5:20: ", "'gear_ratio' must be a number"},
      {kRobot + "test = 1\n", "5:8: ", "write [[robot.test]] for each one"},
      {kRobot + "[robot.test]\nname = \"A\"\n", "5:1: ", "write [[robot.test]] for each one"},
      {kRobot + kLine + "points = 51.5\n", "11:10: ", "'points' must be a whole number"},
      {kRobot + "[[robot.effect]]\neffect = \"e\"\njoint = 1.5\n", "7:9: ", "'joint' must be a whole number"},
      {kRobot + "[[robot.effect]]\neffect = \"e\"\nwidth_deg = [1]\n",
       "7:13: ", "'width_deg' must be a number"},

      // What cannot be.
      {kRobot + "payload_kg = -1\n", "5:14: ", "'payload_kg' = -1 is outside 0 .. 5000"},
      {kRobot + "payload_kg = nan\n", "5:14: ", "'payload_kg' = nan is outside 0 .. 5000"},
      {kRobot + "payload_kg = inf\n", "5:14: ", "'payload_kg' = inf is outside 0 .. 5000"},
      {kRobot + "payload_com_mm = [0, 0]\n", "5:18: ", "'payload_com_mm' must hold 3 numbers, not 2"},
      {kRobot + "joints = \"motor\"\n", "5:10: ", "'joints' is \"feedback\" or \"commanded\", not \"motor\""},
      {kRobot + "joint_convention = \"abb\"\n",
       "5:20: ", "'joint_convention' is \"serial\" or \"fanuc\", not \"abb\""},
      {kRobot + "base = \"\"\n", "5:8: ", "'base' is empty"},
      {"[[robot]]\nname = \"" + many_a + "\"\nurdf = \"r.urdf\"\n",
       "2:8: ", "'name' is longer than 100 bytes"},
      {kRobot + "[[robot.test]]\nname = \"" + many_a + "\"\n", "6:8: ", "'name' is longer than 100 bytes"},
      {kRobot + "[[robot.test]]\nname = \"A\"\nkind = \"square\"\n",
       "7:8: ", "'kind' is \"circle\" or \"line\", not \"square\""},
      {kRobot + kCircle + "virtual_centre = \"ball\"\n",
       "11:18: ", "'virtual_centre' is \"configured\" or \"fitted\", not \"ball\""},
      {kRobot + kCircle + "filter_upr = 0.5\n", "11:14: ", "'filter_upr'"},
      {kRobot + "expansion_ppm_k = -1\n", "5:19: ", "'expansion_ppm_k' = -1 is outside 0 .. 100"},
      {kRobot + kLine + "filter_upr = 50\n", "11:1: ", "unknown key 'filter_upr'"},
      {kRobot + kLine + "virtual_centre = \"fitted\"\n", "11:1: ", "unknown key 'virtual_centre'"},
      {kRobot + kCircle + "normal = [0, 0, 0]\n", "11:10: ", "'normal' has no length"},
      {kRobot + kCircle + "normal = [0, 0, 2]\nfirst_axis = [0, 0, 5]\n",
       "12:14: ", "'first_axis' is parallel to 'normal'"},
      {kRobot + kCircle + "normal = [0, 0, 2]\nfirst_axis = [0, 0, -5]\n",
       "12:14: ", "'first_axis' is parallel to 'normal'"},
      {kRobot + kCircle + "first_axis = [0, 0, 0]\n", "11:14: ", "'first_axis' has no length"},
      {kRobot + kCircle + "arc_deg = [0, 9]\n", "11:11: ", "sweep of 10 to 360"},
      {kRobot + kCircle + "arc_deg = [0, -360]\n", "11:11: ", "sweep of 10 to 360"},
      {kRobot + kCircle + "arc_deg = [0]\n", "11:11: ", "'arc_deg' must be [start, sweep]"},
      {kRobot + kCircle + "arc_deg = []\n", "11:11: ", "'arc_deg' must be [start, sweep]"},
      {kRobot + kCircle + "arc_deg = [0, 361]\n", "11:15: ", "'arc_deg' = 361 is outside -360 .. 360"},
      {kRobot + kCircle + "overshoot_deg = -1\n", "11:17: ", "'overshoot_deg' = -1 is outside 0 .. 360"},
      {kRobot + kCircle + "feed_mm_s = -5\n", "11:13: ", "'feed_mm_s' = -5 is outside 0 .. 10000"},
      {kRobot + kCircle + "posture_deg = []\n",
       "11:15: ", "'posture_deg' is empty; give one angle per joint"},
      {kRobot + kCircle + "posture_deg = [0, 0, \"up\"]\n", "11:22: ", "'posture_deg' must be a number"},
      {kRobot + kCircle + "posture_deg = [0, 0, 800]\n",
       "11:22: ", "'posture_deg' = 800 is outside -720 .. 720"},
      {kRobot + kCircle + "tool_rpy_deg = [180, 0, 400]\n",
       "11:25: ", "'tool_rpy_deg' = 400 is outside -360 .. 360"},
      {kRobot + kLine + "points = -1\n", "11:10: ", "'points' = -1 is outside 0 .. 100000"},
      {kRobot + "[[robot.test]]\nname = \"A\"\nkind = \"circle\"\ncentre_mm = [1, 2, 3]\nradius_mm = 0\n",
       "9:13: ", "'radius_mm' = 0 is outside 1 .. 5000"},
      {kRobot + "[[robot.test]]\nname = \"A\"\nkind = \"circle\"\ncentre_mm = [1, 2, 1e9]\n",
       "8:20: ", "'centre_mm' = 1e+09 is outside -20000 .. 20000"},
      {kRobot + "[[robot.test]]\nname = \"Y\"\nkind = \"line\"\nstart_mm = [1, 2, 3]\nend_mm = [1, 2, 3]\n",
       "5:1: ", "start_mm is its end_mm"},

      // What is missing.
      {"\n[[robot]]\nurdf = \"r.urdf\"\n", "2:1: ", "[[robot]] needs 'name'"},
      {"[[robot]]\nname = \"r1\"\n", "1:1: ", "[[robot]] needs 'urdf'"},
      {kRobot + "[[robot.test]]\nkind = \"circle\"\n", "5:1: ", "[[robot.test]] needs 'name'"},
      {kRobot + "[[robot.test]]\nname = \"A\"\n", "5:1: ", "[[robot.test]] needs 'kind'"},
      {kRobot + "[[robot.test]]\nname = \"A\"\nkind = \"circle\"\n",
       "5:1: ", "[[robot.test]] needs 'centre_mm'"},
      {kRobot + "[[robot.test]]\nname = \"A\"\nkind = \"circle\"\ncentre_mm = [1, 2, 3]\n",
       "5:1: ", "needs 'radius_mm'"},
      {kRobot + "[[robot.test]]\nname = \"Y\"\nkind = \"line\"\nend_mm = [1, 2, 3]\n",
       "5:1: ", "needs 'start_mm'"},
      {kRobot + "[[robot.test]]\nname = \"Y\"\nkind = \"line\"\nstart_mm = [1, 2, 3]\n",
       "5:1: ", "needs 'end_mm'"},
      {kRobot + "[[robot.effect]]\njoint = 3\n", "5:1: ", "[[robot.effect]] needs 'effect'"},

      // Effects that the catalogue does not hold.
      {kRobot + "[[robot.effect]]\neffect = \"joint_zero_ofset\"\njoint = 3\noffset_deg = 0.1\n",
       "6:10: ", "unknown effect 'joint_zero_ofset'; did you mean 'joint_zero_offset'?"},
      {kRobot + "[[robot.effect]]\neffect = \"joint_zero_offset\"\njoint = 3\n",
       "5:1: ", "'joint_zero_offset' needs 'offset_deg'"},
      {kRobot + "[[robot.effect]]\neffect = \"joint_zero_offset\"\noffset_deg = 0.1\n",
       "5:1: ", "'joint_zero_offset' needs 'joint'"},
      {kRobot + "[[robot.effect]]\neffect = \"base_drift\"\njoint = 1\nx_um = 3\n",
       "7:9: ", "'base_drift' belongs to no joint"},
      {kRobot + "[[robot.effect]]\neffect = \"servo_lag\"\njoint = 1\nlag_s = 0.003\n",
       "8:9: ", "'servo_lag' has no parameter 'lag_s'; did you mean 'lag_ms'?"},
      {kRobot + "[[robot.effect]]\neffect = \"servo_lag\"\njoint = 1\nlag_ms = -3\n",
       "8:10: ", "'lag_ms' = -3 is outside 0 .. 10000"},
      {kRobot + "[[robot.effect]]\neffect = \"servo_lag\"\njoint = 1\nlag_ms = \"3\"\n",
       "8:10: ", "'lag_ms' must be a number"},
      {kRobot +
           "[[robot.effect]]\neffect = \"joint_lost_motion\"\njoint = 1\nwidth_deg = 0.01\nkind = \"play\"\n",
       "9:8: ", "'kind' cannot be \"play\"; known are: backlash, friction_windup, load_friction, unresolved"},
      {kRobot + "[[robot.effect]]\neffect = \"not_in_catalogue\"\n",
       "6:10: ", "'not_in_catalogue' is a finding without a model"},
      {"[[robot]]\nname = \"r1\"\nurdf = \"none.urdf\"\n", "3:8: ", "no file " + dir.path() + "/none.urdf"},
      {"[[robot]]\nname = \"r1\"\nurdf = \"" + std::string(300, 'u') + "\"\n",
       "3:8: ", " cannot be read: File name too long"},

      // Twice.
      {kRobot + kRobot, "7:8: ", "a second robot 'r1'; give it another name"},
      {kRobot + kCircle + kCircle, "12:8: ", "a second test 'A' of this robot; give it another name"},
  };
  for (const Row& row : rows) {
    const std::string got = complaint(row.text);
    EXPECT_TRUE(got.starts_with(row.at)) << "expected at " << row.at << " but got: " << got << "\nof:\n"
                                         << row.text;
    EXPECT_NE(got.find(row.says), std::string::npos)
        << "expected: " << row.says << "\nbut got: " << got << "\nof:\n"
        << row.text;
  }
}

TEST_F(ConfigFile, OneThatCannotBeReadIsNamed) {
  for (const std::string& missing : {dir.path() + "/none.toml", dir.path()}) {
    try {
      load_config(missing);
      ADD_FAILURE() << missing << " was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.cause(), Cause::kInput);
      EXPECT_TRUE(std::string(error.what()).starts_with(missing + ": ")) << error.what();
    }
  }
}

TEST_F(ConfigFile, KeepsHouseOnlyWhereItIsTold) {
  const Config empty = load("");
  EXPECT_EQ(empty.keep_days + empty.keep_traces_days + empty.max_size_mb, 0);
  EXPECT_EQ(empty.metrics_path, "");
  const Config told = load(
      "[store]\nkeep_days = 3650\nkeep_traces_days = 730\nmax_size_mb = 4000\n[metrics]\npath = "
      "\"/x/b.prom\"\n");
  EXPECT_EQ(told.keep_days, 3650);
  EXPECT_EQ(told.keep_traces_days, 730);
  EXPECT_EQ(told.max_size_mb, 4000);
  EXPECT_EQ(told.metrics_path, "/x/b.prom");
  EXPECT_THROW(load("[store]\nmax_size_mb = 1\n"), Error);
  EXPECT_THROW(load("[store]\nkeep_days = 10\nkeep_traces_days = 20\n"), Error);
}

TEST_F(ConfigFile, ShippedRulesComeBeforeOnesOwn) {
  using Folders = std::vector<std::filesystem::path>;
  EXPECT_EQ(load("[rules]\ndirectory = \"/a\"\n").rule_folders(), Folders{"/a"});
  EXPECT_EQ(load("[rules]\nshipped = \"/s\"\ndirectory = \"/a\"\n").rule_folders(), (Folders{"/s", "/a"}));
}

TEST_F(ConfigFile, WhatIsAbsentHasItsDefault) {
  const Config empty = load("");
  EXPECT_EQ(empty.path, path());
  EXPECT_EQ(empty.bus_url, "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152");
  EXPECT_EQ(empty.store_path, "/var/lib/ballbard/ballbard.db");
  EXPECT_EQ(empty.rules_directory, "/etc/ballbard/rules.d");
  EXPECT_TRUE(empty.robots.empty());

  const RobotSpec robot = load(kRobot).robots.at(0);
  EXPECT_EQ(robot.base, "base");
  EXPECT_EQ(robot.tip, "tcp");
  EXPECT_EQ(robot.joint_convention, JointConvention::kSerial);
  EXPECT_FALSE(robot.joints_commanded);
  EXPECT_TRUE(robot.gear_ratio.empty());
  EXPECT_EQ(robot.payload, 0.0);
  EXPECT_TRUE(robot.tests.empty()) << "a robot may have no tests";

  const TestSpec circle = load(kRobot + kCircle).robots.at(0).tests.at(0);
  expect_vector(circle.circle.normal, {0, 0, 1});
  expect_vector(circle.circle.first_axis, {1, 0, 0});
  EXPECT_EQ(circle.circle.arc_start, 0.0);
  EXPECT_NEAR(circle.circle.arc_sweep, 360.0 * kDeg, 1e-12);
  EXPECT_EQ(circle.circle.overshoot, 0.0);
  EXPECT_EQ(circle.feed, 0.0);
  EXPECT_FALSE(circle.tool_rpy.has_value());
  EXPECT_TRUE(circle.posture.empty());
  EXPECT_FALSE(circle.filter_upr) << "not filtered";
  EXPECT_DOUBLE_EQ(circle.expansion, 11.7e-6) << "steel";
  EXPECT_DOUBLE_EQ(load(kRobot + "expansion_ppm_k = 23\n" + kCircle).robots.at(0).tests.at(0).expansion,
                   23e-6)
      << "the robot's";
  EXPECT_DOUBLE_EQ(load(kRobot + "expansion_ppm_k = 23\n" + kCircle + "expansion_ppm_k = 0\n")
                       .robots.at(0)
                       .tests.at(0)
                       .expansion,
                   0.0)
      << "the test's before the robot's";
  EXPECT_EQ(load(kRobot + kCircle + "filter_upr = 50\n").robots.at(0).tests.at(0).filter_upr, 50.0);
  EXPECT_EQ(circle.virtual_centre, VirtualCentre::kConfigured);
  EXPECT_EQ(load(kRobot + kCircle + "virtual_centre = \"fitted\"\n").robots.at(0).tests.at(0).virtual_centre,
            VirtualCentre::kFitted);
  EXPECT_FALSE(circle.payload.has_value()) << "absent: the robot's payload counts";
}

TEST_F(ConfigFile, EveryFigureIsInSiUnits) {
  const Config config =
      load(kRobot +
           "base = \"world\"\ntip = \"ball\"\njoints = \"commanded\"\njoint_convention = "
           "\"fanuc\"\ngear_ratio = [120, 0, -80.5]\n"
           "payload_kg = 0.438\npayload_com_mm = [1, -2.5, 50]\n" +
           kCircle +
           "arc_deg = [-45, 270]\novershoot_deg = 60\nfeed_mm_s = 55.33\ntool_rpy_deg = [180, 0, -90]\n"
           "payload_kg = 3.0\nposture_deg = [0, 10, -180.5]\n" +
           kLine + "points = 51\nfeed_mm_s = 20\npayload_kg = 0\n");
  const RobotSpec& robot = config.robots.at(0);
  EXPECT_EQ(robot.base, "world");
  EXPECT_EQ(robot.tip, "ball");
  EXPECT_TRUE(robot.joints_commanded);
  EXPECT_EQ(robot.joint_convention, JointConvention::kFanuc);
  EXPECT_EQ(robot.gear_ratio, (std::vector<double>{120, 0, -80.5}));
  EXPECT_DOUBLE_EQ(robot.payload, 0.438);
  expect_vector(robot.payload_com, {0.001, -0.0025, 0.050});

  const TestSpec& a = robot.tests.at(0);
  EXPECT_EQ(a.name, "A");
  EXPECT_EQ(a.kind, TestKind::kCircle);
  expect_vector(a.circle.centre, {0.380, -0.320, -0.251});
  EXPECT_NEAR(a.circle.radius, 0.100, 1e-15);
  EXPECT_NEAR(a.circle.arc_start, -45 * kDeg, 1e-12);
  EXPECT_NEAR(a.circle.arc_sweep, 270 * kDeg, 1e-12);
  EXPECT_NEAR(a.circle.overshoot, 60 * kDeg, 1e-12);
  EXPECT_NEAR(a.feed, 0.05533, 1e-15);
  expect_vector(a.tool_rpy.value(), {180 * kDeg, 0, -90 * kDeg});
  EXPECT_EQ(a.payload, 3.0);
  ASSERT_EQ(a.posture.size(), 3u);
  EXPECT_NEAR(a.posture[2], -180.5 * kDeg, 1e-12);

  const TestSpec& y = robot.tests.at(1);
  EXPECT_EQ(y.kind, TestKind::kLine);
  expect_vector(y.line.start, {0.380, -0.470, -0.251});
  expect_vector(y.line.end, {0.380, 0.470, -0.251});
  EXPECT_EQ(y.line.points, 51);
  EXPECT_NEAR(y.feed, 0.020, 1e-15);
  EXPECT_EQ(y.payload, 0.0) << "0 kg is a payload, not an absent one";
  EXPECT_EQ(robot.find_test("Y"), &y);
  EXPECT_EQ(robot.find_test("Z"), nullptr);
  EXPECT_EQ(config.find_robot("r1"), &robot);
  EXPECT_EQ(config.find_robot("r2"), nullptr);
}

TEST_F(ConfigFile, ThePlaneGetsUnitAxesAndAngleZeroInsideIt) {
  const double half = std::sqrt(0.5);
  expect_vector(circle("normal = [0, 0, -7]\n").normal, {0, 0, -1});
  expect_vector(circle("normal = [1, 0, 0]\n").first_axis,
                {0, 1, 0});  // X has no part in the plane: Y instead
  expect_vector(circle("normal = [-3, 0, 0]\n").first_axis, {0, 1, 0});
  expect_vector(circle("normal = [0, 1, 0]\n").first_axis, {1, 0, 0});
  expect_vector(circle("normal = [1, 0, 1]\n").first_axis, {half, 0, -half});  // X, projected
  expect_vector(circle("first_axis = [0, 5, 5]\n").first_axis, {0, 1, 0});     // given, projected
  expect_vector(circle("normal = [0, 1, 1]\nfirst_axis = [0, 0, 2]\n").first_axis, {0, -half, half});
}

TEST_F(ConfigFile, RelativePathsCountFromItsFolder) {
  std::filesystem::create_directory(dir.path() + "/robots");
  test::write_file(dir.path() + "/robots/x.urdf", "<robot name=\"x\"/>");
  const std::string top = std::filesystem::canonical(dir.path()).string();
  const auto check = [&](const Config& config) {
    EXPECT_EQ(config.store_path, top + "/data/b.db");
    EXPECT_EQ(config.rules_directory, top + "/rules.d");
    EXPECT_EQ(config.robots.at(0).urdf_path, top + "/robots/x.urdf");
  };
  const std::string text =
      "[store]\npath = \"data/b.db\"\n[rules]\ndirectory = \"./rules.d\"\n[[robot]]\nname = \"r\"\nurdf = "
      "\"robots/../robots/x.urdf\"\n";
  check(load(text));
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(dir.path());
  check(load_config("ballbard.toml"));
  std::filesystem::current_path(before);

  EXPECT_EQ(load("[store]\npath = \"/srv/b.db\"\n").store_path, "/srv/b.db");
}

TEST_F(ConfigFile, EffectsAreKeptAsTheyStand) {
  const RobotSpec robot =
      load(kRobot +
           "[[robot.effect]]\neffect = \"joint_zero_offset\"\njoint = 3\noffset_deg = 0.172\n"
           "[[robot.effect]]\neffect = \"joint_lost_motion\"\njoint = 2\nkind = \"backlash\"\nwidth_deg = "
           "0.02\n")
          .robots.at(0);
  ASSERT_EQ(robot.effects.size(), 2u);
  EXPECT_EQ(robot.effects[0].effect, "joint_zero_offset");
  EXPECT_EQ(robot.effects[0].joint, 3);
  EXPECT_EQ(robot.effects[0].parameters, (std::map<std::string, double>{{"offset_deg", 0.172}}));
  EXPECT_EQ(robot.effects[1].joint, 2);
  EXPECT_EQ(robot.effects[1].parameters, (std::map<std::string, double>{{"width_deg", 0.02}}));
  EXPECT_EQ(robot.effects[1].words, (std::map<std::string, std::string>{{"kind", "backlash"}}));
}

TEST_F(ConfigFile, TakesTheExampleOfTheEffectsDocument) {
  const std::string text = read_text(BALLBAR_SOURCE_DIR "/docs/effects.md");
  const std::size_t begin = text.find("```toml\n") + 8;
  const RobotSpec robot = load(kRobot + text.substr(begin, text.find("```", begin) - begin)).robots.at(0);
  ASSERT_EQ(robot.effects.size(), 3u);
  EXPECT_EQ(robot.effects[1].parameters.at("friction_nm"), 1.5);
}

TEST_F(ConfigFile, TwoRobotsMayHaveTestsOfOneName) {
  const Config config = load(kRobot + kCircle + "[[robot]]\nname = \"r2\"\nurdf = \"r.urdf\"\n" + kCircle);
  ASSERT_EQ(config.robots.size(), 2u);
  EXPECT_NE(config.find_robot("r1")->find_test("A"), nullptr);
  EXPECT_NE(config.find_robot("r2")->find_test("A"), nullptr);
}

TEST(ShippedConfig, TheServicesDefaultIsGood) {
  const Config config = load_config(BALLBAR_SOURCE_DIR "/systemd/ballbard.toml");
  EXPECT_EQ(config.bus_url, Config{}.bus_url);
  EXPECT_EQ(config.store_path, Config{}.store_path);
  EXPECT_EQ(config.rules_directory, Config{}.rules_directory);
}

// The example in the comments is what people begin with: uncommented it must be as good as the file.
TEST(ShippedConfig, TheExampleInTheServicesDefaultIsGood) {
  const test::TempDir dir;
  std::istringstream lines(test::read_file(BALLBAR_SOURCE_DIR "/systemd/ballbard.toml"));
  std::string text, line;
  bool inside = false;
  while (std::getline(lines, line)) {
    inside = inside || line == "# [[robot]]";
    if (line.starts_with("# urdf"))
      line = "# urdf = \"" BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.urdf\"";
    if (inside) text += line.substr(std::min<std::size_t>(line.size(), 2)) + "\n";
  }
  test::write_file(dir.path() + "/c.toml", text);
  const Config config = load_config(dir.path() + "/c.toml");
  ASSERT_EQ(config.robots.size(), 1u);
  EXPECT_EQ(config.robots[0].tests.size(), 2u);
}

TEST(ShippedConfig, TheLrMateHasItsThreeTests) {
  const Config config = load_config(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.toml");
  const RobotSpec* robot = config.find_robot("lrmate-1");
  ASSERT_NE(robot, nullptr);
  EXPECT_EQ(robot->joint_convention, JointConvention::kFanuc);
  EXPECT_TRUE(std::filesystem::exists(robot->urdf_path));
  ASSERT_NE(robot->find_test("A"), nullptr);
  ASSERT_NE(robot->find_test("B"), nullptr);
  ASSERT_NE(robot->find_test("Y"), nullptr);
  expect_vector(robot->find_test("A")->circle.centre, {0.380, -0.320, -0.251});
  EXPECT_EQ(robot->find_test("Y")->kind, TestKind::kLine);
}

}  // namespace
}  // namespace ballbar

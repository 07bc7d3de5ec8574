#include "daemon/config.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/config_table.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

constexpr double kLengthLimitMm = 20'000.0;  // of any coordinate: no cell is larger
constexpr int kMostDays = 36'500;
constexpr int kLeastSizeMb = 10;
constexpr std::size_t kMaxNameLength = 100;  // the wire's limit, with room

Vec3 scaled(const Vec3& v, double factor) { return {v[0] * factor, v[1] * factor, v[2] * factor}; }
double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vec3& v) { return std::sqrt(dot(v, v)); }
Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

CircleSpec read_circle(TomlTable& t) {
  CircleSpec circle;
  circle.centre = scaled(t.required_triple("centre_mm", kLengthLimitMm), kMetresPerMm);
  circle.radius = t.required_number("radius_mm", 1.0, 5000.0) * kMetresPerMm;
  circle.normal = t.triple("normal", {0, 0, 1}, 1e6);
  if (length(circle.normal) < 1e-9)
    t.fail(t.find("normal"), "'normal' has no length; give the plane's normal, e.g. [0, 0, 1]");
  circle.normal = scaled(circle.normal, 1.0 / length(circle.normal));
  const bool normal_near_x = std::abs(circle.normal[0]) > 0.9;
  const Vec3 axis = t.triple("first_axis", normal_near_x ? Vec3{0, 1, 0} : Vec3{1, 0, 0}, 1e6);
  if (length(axis) < 1e-9)
    t.fail(t.find("first_axis"),
           "'first_axis' has no length; give an axis that lies near the plane, e.g. [1, 0, 0]");
  const Vec3 in_plane = minus(axis, scaled(circle.normal, dot(axis, circle.normal)));
  if (length(in_plane) < 1e-6 * length(axis))
    t.fail(t.find("first_axis"),
           "'first_axis' is parallel to 'normal'; give an axis that lies near the plane");
  circle.first_axis = scaled(in_plane, 1.0 / length(in_plane));
  const toml::node* arc_node = t.find("arc_deg");
  std::vector<double> arc = t.numbers("arc_deg", -360.0, 360.0);
  if (!arc_node) arc = {0.0, 360.0};
  if (arc.size() != 2 || arc[1] < 10.0)
    t.fail(arc_node, "'arc_deg' must be [start, sweep] with a sweep of 10 to 360");
  circle.arc_start = arc[0] * kRadPerDeg;
  circle.arc_sweep = arc[1] * kRadPerDeg;
  circle.overshoot = t.number("overshoot_deg", 0.0, 0.0, 360.0) * kRadPerDeg;
  return circle;
}

LineSpec read_line(TomlTable& t) {
  LineSpec line;
  line.start = scaled(t.required_triple("start_mm", kLengthLimitMm), kMetresPerMm);
  line.end = scaled(t.required_triple("end_mm", kLengthLimitMm), kMetresPerMm);
  if (length(minus(line.end, line.start)) < 1e-6)
    t.fail(nullptr, "a line whose start_mm is its end_mm has no direction");
  line.points = t.whole("points", 0, 0, 100'000);
  return line;
}

/// @param otherwise  [1/K] where the table does not say
double read_expansion(TomlTable& t, double otherwise) {
  return t.number("expansion_ppm_k", to_ppm(otherwise), 0.0, 100.0) * kPerPpm;
}

/// @param expansion  [1/K] the robot's
TestSpec read_test(TomlTable& t, const std::set<std::string>& taken, double expansion) {
  TestSpec test;
  test.name = t.required_text("name");
  if (test.name.size() > kMaxNameLength) t.fail(t.find("name"), "'name' is longer than 100 bytes");
  if (taken.contains(test.name))
    t.fail(t.find("name"), "a second test '" + test.name + "' of this robot; give it another name");
  const std::string kind = t.required_text("kind");
  if (kind == "circle") {
    test.circle = read_circle(t);
    const std::string centre = t.text("virtual_centre", "configured");
    if (centre != "configured" && centre != "fitted")
      t.fail(t.find("virtual_centre"),
             "'virtual_centre' is \"configured\" or \"fitted\", not \"" + centre + "\"");
    if (centre == "fitted") test.virtual_centre = VirtualCentre::kFitted;
    if (t.find("filter_upr")) test.filter_upr = t.number("filter_upr", 0.0, 1.0, 1000.0);
    test.expansion = read_expansion(t, expansion);
  } else if (kind == "line") {
    test.kind = TestKind::kLine;
    test.line = read_line(t);
  } else {
    t.fail(t.find("kind"), "'kind' is \"circle\" or \"line\", not \"" + kind + "\"");
  }
  test.feed = t.number("feed_mm_s", 0.0, 0.0, 10'000.0) * kMetresPerMm;
  if (t.find("tool_rpy_deg")) test.tool_rpy = scaled(t.triple("tool_rpy_deg", {}, 360.0), kRadPerDeg);
  if (t.find("payload_kg")) test.payload = t.number("payload_kg", 0.0, 0.0, 5000.0);
  const toml::node* posture_node = t.find("posture_deg");
  test.posture = t.numbers("posture_deg", -720.0, 720.0);
  if (posture_node && test.posture.empty())
    t.fail(posture_node, "'posture_deg' is empty; give one angle per joint, as on the teach pendant");
  for (double& angle : test.posture) angle *= kRadPerDeg;
  return test;
}

/// Which joints there are is only known with the URDF: AsBuilt checks that.
EffectSpec read_effect(TomlTable& t) {
  EffectSpec effect;
  effect.effect = t.required_text("effect");
  effect.joint = t.whole("joint", 0, 0, 16);
  for (const auto& [key, node] : t.raw()) {
    const std::string name(key.str());
    if (name == "effect" || name == "joint") continue;
    t.find(name.c_str());
    if (node.is_string())
      effect.words[name] = *node.value<std::string>();
    else
      effect.parameters[name] = t.number(node, name, -1e12, 1e18);
  }
  if (const std::optional<EffectFault> fault = effect_fault(effect))
    t.fail(fault->key.empty() ? nullptr : t.find(fault->key.c_str()), fault->what);
  return effect;
}

std::string beside(const std::string& config_path, const std::string& path) {
  const std::filesystem::path given(path);
  if (given.is_absolute()) return path;
  return (std::filesystem::absolute(config_path).parent_path() / given).lexically_normal().string();
}

RobotSpec read_robot(TomlTable& t) {
  RobotSpec robot;
  robot.name = t.required_text("name");
  if (robot.name.size() > kMaxNameLength) t.fail(t.find("name"), "'name' is longer than 100 bytes");
  robot.urdf_path = beside(t.path(), t.required_text("urdf"));
  std::error_code why_not;
  if (!std::filesystem::exists(robot.urdf_path, why_not))
    t.fail(t.find("urdf"),
           why_not ? robot.urdf_path + " cannot be read: " + why_not.message() +
                         "; the service needs the right to, and sees no home folders"
                   : "no file " + robot.urdf_path + "; relative paths count from this file's folder");
  robot.base = t.text("base", robot.base);
  robot.tip = t.text("tip", robot.tip);
  const std::string convention = t.text("joint_convention", "serial");
  if (convention != "serial" && convention != "fanuc")
    t.fail(t.find("joint_convention"),
           "'joint_convention' is \"serial\" or \"fanuc\", not \"" + convention + "\"");
  robot.joint_convention = convention == "fanuc" ? JointConvention::kFanuc : JointConvention::kSerial;
  const std::string joints = t.text("joints", "feedback");
  if (joints != "feedback" && joints != "commanded")
    t.fail(t.find("joints"), "'joints' is \"feedback\" or \"commanded\", not \"" + joints + "\"");
  robot.joints_commanded = joints == "commanded";
  robot.gear_ratio = t.numbers("gear_ratio", -1e5, 1e5);
  robot.payload = t.number("payload_kg", 0.0, 0.0, 5000.0);
  robot.payload_com = scaled(t.triple("payload_com_mm", {0, 0, 0}, 5000.0), kMetresPerMm);
  const double expansion = read_expansion(t, kSteelExpansion);
  std::set<std::string> taken;
  t.each("test", "robot.test", [&](TomlTable& test) {
    robot.tests.push_back(read_test(test, taken, expansion));
    taken.insert(robot.tests.back().name);
  });
  t.each("effect", "robot.effect", [&](TomlTable& effect) { robot.effects.push_back(read_effect(effect)); });
  return robot;
}

NotifySpec read_notify(TomlTable& t) {
  NotifySpec notify;
  const toml::node* node = t.find("command");
  const toml::array* words = node ? node->as_array() : nullptr;
  if (!words || words->empty())
    t.fail(node,
           "'command' is a list: the program by its whole path, then its words, e.g. "
           "[\"/usr/share/ballbard/notify-mail\", \"maintenance@example.com\"]");
  for (const toml::node& word : *words) {
    const std::optional<std::string> text = word.value<std::string>();
    if (!text || !word.is_string()) t.fail(&word, "each word of 'command' must be text in quotes");
    notify.command.push_back(*text);
  }
  if (notify.command[0].empty() || notify.command[0][0] != '/')
    t.fail(node, "'command' begins with the whole path of a program, e.g. /usr/share/ballbard/notify-mail");
  notify.time_limit_s = t.number("time_limit_s", notify.time_limit_s, 0.1, 3600.0);
  notify.retry_s = t.number("retry_s", notify.retry_s, 0.1, 600.0);
  notify.severity = t.text("severity", notify.severity);
  if (notify.severity != "info" && notify.severity != "warning" && notify.severity != "critical")
    t.fail(t.find("severity"),
           "'severity' is \"info\", \"warning\" or \"critical\", not \"" + notify.severity + "\"");
  return notify;
}

}  // namespace

std::vector<std::filesystem::path> Config::rule_folders() const {
  if (rules_shipped.empty()) return {rules_directory};
  return {rules_shipped, rules_directory};
}

const RobotSpec* Config::find_robot(const std::string& name) const {
  const auto found =
      std::find_if(robots.begin(), robots.end(), [&](const RobotSpec& r) { return r.name == name; });
  return found == robots.end() ? nullptr : &*found;
}

std::string read_text(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw Error(Cause::kInput, path + ": is a folder, not a file");
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file)
    throw Error(Cause::kInput, path + ": cannot be read; is the path right, and may this user read it?");
  return text.str();
}

void write_text(const std::string& path, const std::string& text) {
  const std::string draft = path + ".part";
  {
    std::ofstream file(draft, std::ios::binary);
    file << text;
    file.close();
    if (!file) throw Error(Cause::kWorld, path + ": cannot be written");
  }
  std::error_code error;
  std::filesystem::rename(draft, path, error);
  if (error) throw Error(Cause::kWorld, path + ": cannot be written: " + error.message());
}

Config load_config(const std::string& path) {
  const std::string text = read_text(path);
  toml::table document;
  try {
    document = toml::parse(std::string_view(text), std::string_view(path));
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw Error(Cause::kInput, path + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " +
                                   std::string(error.description()));
  }
  Config config;
  config.path = path;
  TomlTable top(document, "the configuration", path);
  top.section("bus", [&](TomlTable& t) { config.bus_url = t.text("url", config.bus_url); });
  top.section("store", [&](TomlTable& t) {
    config.store_path = beside(path, t.text("path", config.store_path));
    config.keep_days = t.whole("keep_days", 0, 0, kMostDays);
    config.keep_traces_days = t.whole("keep_traces_days", 0, 0, kMostDays);
    config.max_size_mb = t.whole("max_size_mb", 0, 0, 1'000'000);
    if (config.max_size_mb != 0 && config.max_size_mb < kLeastSizeMb)
      t.fail(t.find("max_size_mb"),
             "'max_size_mb' is less than 10, which an empty database nearly takes; 0: any size");
    if (config.keep_days != 0 && config.keep_traces_days > config.keep_days)
      t.fail(t.find("keep_traces_days"),
             "'keep_traces_days' is longer than 'keep_days', and a recording goes with its run");
  });
  top.section("metrics", [&](TomlTable& t) {
    if (t.find("path")) config.metrics_path = beside(path, t.required_text("path"));
  });
  top.section("rules", [&](TomlTable& t) {
    config.rules_directory = beside(path, t.text("directory", config.rules_directory));
    if (t.find("shipped")) config.rules_shipped = beside(path, t.required_text("shipped"));
  });
  top.section("control", [&](TomlTable& t) {
    config.control_socket = beside(path, t.text("socket", config.control_socket));
  });
  top.section("notify", [&](TomlTable& t) { config.notify = read_notify(t); });
  top.section("diagnosis", [&](TomlTable& t) {
    config.live_diagnosis = t.flag("live", config.live_diagnosis);
    config.series_ends_after = t.number("series_ends_after_s", config.series_ends_after, 1.0, 1e6);
  });
  top.each("robot", "robot", [&](TomlTable& t) {
    config.robots.push_back(read_robot(t));
    const std::string& name = config.robots.back().name;
    for (std::size_t i = 0; i + 1 < config.robots.size(); ++i)
      if (config.robots[i].name == name)
        t.fail(t.find("name"), "a second robot '" + name + "'; give it another name");
  });
  top.done();
  return config;
}

}  // namespace ballbar

#include "files/poses_csv.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "core/error.hpp"
#include "core/units.hpp"
#include "files/numbers.hpp"
#include "files/text.hpp"

namespace ballbar {
namespace {

constexpr double kMostDegrees = 36'000.0;  // a hundred turns: above it the unit is wrong

std::vector<std::string> fields_of(std::string_view line, char separator) {
  std::vector<std::string> fields;
  while (true) {
    const std::size_t end = line.find(separator);
    std::string_view field = trimmed(line.substr(0, end));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
      field = trimmed(field.substr(1, field.size() - 2));
    fields.emplace_back(field);
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
  }
}

/// One line under the heading.
class Row {
 public:
  Row(const std::map<std::string, std::size_t>& columns, const std::vector<std::string>& fields,
      std::size_t line)
      : columns_(columns), fields_(fields), line_(line) {}

  bool has(const std::string& column) const {
    const auto found = columns_.find(column);
    return found != columns_.end() && !fields_[found->second].empty();
  }
  std::string text(const std::string& column) const {
    return has(column) ? fields_[columns_.at(column)] : std::string();
  }
  double number(const std::string& column) const {
    const std::string& field = fields_[columns_.at(column)];
    const std::optional<double> value = number_from(field);
    if (value) return *value;
    throw refused("line " + std::to_string(line_) + ", " + column + ": " + quoted(field) + " is no number" +
                  (number_from(field, ',') ? "; write decimals with a point" : ""));
  }
  std::optional<double> optional_number(const std::string& column) const {
    return has(column) ? std::optional<double>(number(column)) : std::nullopt;
  }
  std::vector<double> angles(const char* letter, int joints) const {
    std::vector<double> angles;
    for (int j = 1; j <= joints; ++j) {
      const std::string column = letter + std::to_string(j) + "_deg";
      const double angle = number(column);
      if (std::abs(angle) > kMostDegrees)
        throw refused("line " + std::to_string(line_) + ", " + column + ": " + quoted(text(column)) +
                      " can hardly be degrees");
      angles.push_back(angle * kRadPerDeg);
    }
    return angles;
  }
  /// One of a few whole numbers.
  int choice(const std::string& column, std::initializer_list<int> allowed) const {
    const double value = number(column);
    for (const int each : allowed)
      if (value == each) return each;
    throw refused("line " + std::to_string(line_) + ", " + column + ": " + quoted(text(column)) +
                  (column == "held_out" ? " is neither 0 nor 1" : " is none of 1, -1 and 0 (not known)"));
  }

 private:
  const std::map<std::string, std::size_t>& columns_;
  const std::vector<std::string>& fields_;
  std::size_t line_;
};

std::map<std::string, std::size_t> columns_of(const std::vector<std::string>& names) {
  std::map<std::string, std::size_t> columns;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!names[i].empty() && !columns.emplace(names[i], i).second)
      throw refused("line 1: two columns are named " + quoted(names[i]));
  return columns;
}

/// How many of q1_deg, q2_deg, ... there are.
int joints_in(const std::map<std::string, std::size_t>& columns, const std::string& letter) {
  int joints = 0;
  while (columns.count(letter + std::to_string(joints + 1) + "_deg") > 0) ++joints;
  return joints;
}

void check(const std::map<std::string, std::size_t>& columns, int joints) {
  const auto has = [&](const char* name) { return columns.count(name) > 0; };
  const int found = joints_in(columns, "q");
  if (found != joints)
    throw refused("the heading names " + std::to_string(found) +
                  " of the columns q1_deg.. and the robot has " + std::to_string(joints) +
                  " joints; name them q1_deg to q" + std::to_string(joints) + "_deg");
  const int commanded = joints_in(columns, "c");
  if (commanded != 0 && commanded != joints)
    throw refused("the heading names " + std::to_string(commanded) +
                  " of the columns c1_deg.. and the robot has " + std::to_string(joints) +
                  " joints; give all or none");
  const int point = int{has("x_mm")} + int{has("y_mm")} + int{has("z_mm")};
  if (point == 3 && has("length_mm"))
    throw refused("the heading names x_mm, y_mm, z_mm and length_mm: which was measured? Rename the other");
  if (point != 3 && !has("length_mm"))
    throw refused("the heading lacks x_mm, y_mm, z_mm (a measured point) or length_mm (a measured length)");
}

Pose pose_of(const Row& row, int joints, bool lengths, bool commands) {
  Pose pose;
  pose.joints = row.angles("q", joints);
  if (commands) pose.command = row.angles("c", joints);
  if (lengths)
    pose.length = row.number("length_mm") * kMetresPerMm;
  else
    pose.point = {row.number("x_mm") * kMetresPerMm, row.number("y_mm") * kMetresPerMm,
                  row.number("z_mm") * kMetresPerMm};
  pose.series = row.text("series");
  pose.tool = row.text("point");
  pose.time = row.optional_number("time_s");
  pose.payload = row.optional_number("payload_kg");
  pose.temperature = row.optional_number("temperature_c");
  if (row.has("direction")) pose.direction = row.choice("direction", {1, -1, 0});
  if (row.has("held_out")) pose.held_out = row.choice("held_out", {0, 1}) == 1;
  return pose;
}

void check(const Pose& pose, bool lengths, std::size_t line) {
  const std::string where = "line " + std::to_string(line) + ", ";
  if (lengths && !(pose.length > 0.0)) throw refused(where + "length_mm: a length above 0 is needed");
  if (pose.payload && (*pose.payload < 0.0 || *pose.payload > 10'000.0))
    throw refused(where + "payload_kg: must be from 0 to 10000");
}

}  // namespace

PoseSet read_poses(std::string_view bytes, int joints) {
  bytes = checked_text(bytes);
  PoseSet set;
  std::map<std::string, std::size_t> columns;
  char separator = ',';
  std::size_t line = 0, names = 0;
  bool commands = false;
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    const std::string_view text = trimmed(bytes.substr(0, end));
    ++line;
    if (end == std::string_view::npos && !text.empty())
      throw refused("line " + std::to_string(line) +
                    ": has no end: is the file cut short? If not, add a line break");
    bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + 1);
    if (text.empty() || text.front() == '#') continue;
    if (names == 0) {
      for (const char c : {'\t', ';'})
        if (text.find(c) != std::string_view::npos) separator = c;
      const std::vector<std::string> heading = fields_of(text, separator);
      names = heading.size();
      columns = columns_of(heading);
      check(columns, joints);
      set.lengths = columns.count("length_mm") > 0;
      set.held_out_column = columns.count("held_out") > 0;
      commands = joints_in(columns, "c") > 0;
      continue;
    }
    const std::vector<std::string> fields = fields_of(text, separator);
    if (fields.size() != names)
      throw refused("line " + std::to_string(line) + ": has " + std::to_string(fields.size()) +
                    " columns, the heading " + std::to_string(names));
    if (set.poses.size() == kMaxPoses) throw refused("has more than " + std::to_string(kMaxPoses) + " poses");
    set.poses.push_back(pose_of(Row(columns, fields, line), joints, set.lengths, commands));
    set.poses.back().row = static_cast<int>(set.poses.size());
    check(set.poses.back(), set.lengths, line);
  }
  if (names == 0)
    throw refused("holds no heading; name the columns q1_deg.. and x_mm,y_mm,z_mm or length_mm");
  if (set.poses.empty()) throw refused("holds names of columns, but no poses");
  return set;
}

}  // namespace ballbar

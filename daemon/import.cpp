#include "daemon/import.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "bus/decode.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "files/b5r.hpp"
#include "files/numbers.hpp"
#include "files/recording.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kBetweenRunsUs = 600'000'000;

Error refused(const std::string& why) { return {Cause::kInput, why}; }

std::string read_file(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw refused("cannot be read; is the path right?");
  if (std::filesystem::is_directory(status)) throw refused("is a folder; give a .b5r or CSV file");
  if (!std::filesystem::is_regular_file(status))
    throw refused("is no ordinary file; give a .b5r or CSV file");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size > kMaxImportBytes)
    throw refused("holds " + std::to_string(size / 1'000'000) + " MB; a recording has at most " +
                  std::to_string(kMaxImportBytes / 1'000'000));
  std::string bytes(error ? 0 : size, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (error || !file || static_cast<std::uintmax_t>(file.gcount()) != size)
    throw refused("cannot be read; may you read it?");
  if (bytes.empty()) throw refused("is empty");
  return bytes;
}

bool is_xml(const std::string& path, const std::string& bytes) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const std::string_view text =
      trimmed(std::string_view(bytes).substr(bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0));
  return ending == ".b5r" || text.starts_with('<');
}

/// What was typed, without any file: found wrong before a file is read.
struct Chosen {
  const ImportOptions& typed;
  const RobotSpec& robot;
  std::optional<std::int64_t> started_us;
  int direction = 0;  // 0: not given
  char axis = '\0';
};

const RobotSpec& robot_of(const ImportOptions& options, const Config& config) {
  std::string names;
  for (const RobotSpec& robot : config.robots) names += (names.empty() ? "'" : ", '") + robot.name + "'";
  if (config.robots.empty()) throw refused(config.path + ": no robot is configured");
  if (options.robot.empty() && config.robots.size() > 1)
    throw refused("which robot? give --robot, one of " + names);
  const RobotSpec* robot = options.robot.empty() ? &config.robots.front() : config.find_robot(options.robot);
  if (!robot) throw refused("no robot '" + options.robot + "' is configured; there are " + names);
  return *robot;
}

Chosen choose(const ImportOptions& options, const Config& config) {
  Chosen chosen{options, robot_of(options, config), {}, 0, '\0'};
  if (!options.started.empty()) {
    chosen.started_us = time_us_from(options.started);
    if (!chosen.started_us)
      throw refused("--started: '" + options.started + "' is no time; write it as 2026-03-11T09:00:00Z");
    if (options.files.size() > 1) throw refused("--started is of one recording; import the files one by one");
  }
  const std::string& way = options.direction;
  if (way == "ccw" || way == "forward") chosen.direction = 1;
  if (way == "cw" || way == "backward") chosen.direction = -1;
  if (!options.axis.empty()) chosen.axis = options.axis.front();
  if (printable(options.series) != options.series)
    throw refused("--series: holds what cannot be printed; give plain UTF-8 text");
  if (!options.csv.unit.empty() && !metres_per(options.csv.unit))
    throw refused("--unit: '" + options.csv.unit + "' is no unit of length; " + kLengthUnits + " are");
  return chosen;
}

const TestSpec& test_of(const Chosen& chosen, const std::string& named_by_file) {
  std::string names;
  for (const TestSpec& test : chosen.robot.tests) names += (names.empty() ? "'" : ", '") + test.name + "'";
  const std::string& name = chosen.typed.test.empty() ? named_by_file : chosen.typed.test;
  if (name.empty()) throw refused("which test? give --test, one of " + names);
  const TestSpec* test = chosen.robot.find_test(name);
  if (!test)
    throw refused("robot '" + chosen.robot.name + "' has no test '" + name + "'; give --test, one of " +
                  names);
  return *test;
}

RecordingFacts facts_of(const Chosen& chosen, const TestSpec& test, std::size_t file) {
  const ImportOptions& typed = chosen.typed;
  RecordingFacts facts;
  facts.robot = chosen.robot.name;
  facts.series = typed.series;
  facts.direction = chosen.direction;
  facts.repetition = typed.repetition + static_cast<int>(file);
  facts.feed = typed.feed_mm_s * kMetresPerMm;
  facts.payload = typed.payload_kg.value_or(test.payload.value_or(chosen.robot.payload));
  facts.temperature = typed.temperature_c;
  facts.with_overshoot = typed.with_overshoot;
  return facts;
}

std::int64_t begin_of(const Chosen& chosen, const std::string& in_file) {
  if (chosen.started_us) return *chosen.started_us;
  if (in_file.empty())
    throw refused("when was it recorded? the file does not say: give --started 2026-03-11T09:00:00Z");
  const std::optional<std::int64_t> us = time_us_from(in_file);
  if (!us)
    throw refused("DATE_STARTED is '" + printable(in_file) +
                  "', which is not of the form 2026-03-11T09:00:00: give "
                  "--started");
  return *us;
}

std::string about_of(const B5rFile& file) {
  std::string about = "ballbar test";
  const auto add = [&about](const char* what, const std::string& text) {
    if (!text.empty()) about += std::string(", ") + what + " " + printable(text);
  };
  add("named", file.test);
  add("plane", file.plane);
  add("machine", file.machine);
  add("started", file.started);
  add("operator", file.person);
  add("bar", file.serial);
  add("calibrated", file.calibrated);
  return about;
}

Import import_b5r(const Chosen& chosen, std::size_t index, const std::string& bytes) {
  if (chosen.direction != 0)
    throw refused("a .b5r says itself which way each run went; leave out --direction");
  const std::string& unit = chosen.typed.csv.unit;
  if (unit.empty())
    throw refused(std::string("a .b5r does not say the unit of its readings: give --unit, one of ") +
                  kLengthUnits);
  const B5rFile file = read_b5r(bytes);
  const TestSpec& test = test_of(chosen, file.test);
  if (test.kind != TestKind::kCircle) throw refused("is of a circle, the test '" + test.name + "' is a line");
  const int sense = file.plane.empty() ? 1 : sense_of(file.plane, test.circle);
  const std::int64_t begin = begin_of(chosen, file.started);
  Import found{"", about_of(file), {}};
  for (const B5rRun& run : file.runs) {
    RecordingFacts facts = facts_of(chosen, test, index);
    facts.direction = sense * run.direction;
    facts.started_us = begin + kBetweenRunsUs * static_cast<std::int64_t>(found.runs.size());
    // A second run the same way is a repetition.
    for (const Run& earlier : found.runs) facts.repetition += earlier.direction == facts.direction;
    CsvReadings readings;
    for (const double r : run.readings) readings.deviation.push_back(r * *metres_per(unit));
    found.runs.push_back(circle_from(readings, test, facts));
  }
  return found;
}

Import import_csv(const Chosen& chosen, std::size_t index, const std::string& bytes) {
  const TestSpec& test = test_of(chosen, "");
  const bool circle = test.kind == TestKind::kCircle;
  const std::string& way = chosen.typed.direction;
  if (chosen.direction == 0 || circle != (way == "ccw" || way == "cw"))
    throw refused(std::string("which way? give --direction ") +
                  (circle ? "ccw or cw" : "forward or backward"));
  RecordingFacts facts = facts_of(chosen, test, index);
  const CsvReadings readings = read_csv(bytes, chosen.typed.csv);
  facts.started_us = begin_of(chosen, "");
  Import found{"", "CSV, " + std::to_string(readings.deviation.size()) + " readings", {}};
  found.runs.push_back(circle ? circle_from(readings, test, facts)
                              : line_from(readings, test, facts, chosen.axis));
  return found;
}

bool alike(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr double kRounding = 1e-9;  // [m] as recordings are stored
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](double x, double y) { return std::abs(x - y) <= kRounding; });
}

std::vector<double> deviations_of(const Run& run) {
  std::vector<double> all;
  for (const InterferometerReading& r : run.readings) all.push_back(r.deviation);
  return all;
}

}  // namespace

std::vector<Import> read_imports(const ImportOptions& options, const Config& config) {
  const Chosen chosen = choose(options, config);
  std::vector<Import> all;
  for (std::size_t i = 0; i < options.files.size(); ++i) {
    try {
      const std::string bytes = read_file(options.files[i]);
      Import& found = all.emplace_back(is_xml(options.files[i], bytes) ? import_b5r(chosen, i, bytes)
                                                                       : import_csv(chosen, i, bytes));
      found.path = options.files[i];
    } catch (const Error& error) {
      throw Error(error.cause(), options.files[i] + ": " + error.what());
    }
  }
  return all;
}

bool same_recording(const Run& a, const Run& b) {
  return a.robot == b.robot && a.test == b.test && a.kind == b.kind && a.direction == b.direction &&
         alike(a.bar_deviation, b.bar_deviation) && alike(deviations_of(a), deviations_of(b));
}

}  // namespace ballbar

#pragma once
/// A second, independent way into the recordings of the paper (shared/data/recordings): its own reader of LCM
/// logs and its own forward kinematics, from the Denavit-Hartenberg table of metrology.md 3. Shares no code
/// with the library that it judges.

#include <Eigen/Geometry>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace ballbar::test {

/// Bar samples of one run, between its marks.
struct RecordedCircle {
  std::string test, series;
  int direction = 0;
  int repetition = 0;
  std::int64_t begin_us = 0;      ///< of the begin mark
  double duration = 0.0;          ///< [s] begin mark to end mark
  double feed = 0.0;              ///< [m/s] as in the mark
  Eigen::VectorXd bar_time;       ///< [s] since the begin mark
  Eigen::VectorXd bar_deviation;  ///< [m]
  Eigen::Matrix3Xd tool;          ///< [m] World; one column per bar sample, NaN outside the joint samples
  std::string name() const { return test + (direction > 0 ? "+1#" : "-1#") + std::to_string(repetition); }
};

/// Readings of one run in one axis.
struct RecordedLine {
  std::string test, axis;
  int direction = 0;
  int repetition = 0;
  std::vector<double> position;   ///< [m]
  std::vector<double> deviation;  ///< [m]
};

struct PaperRecording {
  std::vector<RecordedCircle> circles;
  std::vector<RecordedLine> lines;
};

/// Tool point (0, 0, 74.65) mm of the LR Mate 200iC in World [m]. @param q six angles [rad], J3 as on the
/// teach pendant
inline Eigen::Vector3d lr_mate_tool(const Eigen::Matrix<double, 6, 1>& q) {
  constexpr double kQuarter = std::numbers::pi / 2.0;
  struct Row {
    double theta, d, a, alpha;
  };
  const Row table[] = {{q[0], 0.0, 0.075, -kQuarter},        {q[1] - kQuarter, 0.0, 0.3, 2.0 * kQuarter},
                       {q[1] + q[2], 0.0, 0.075, -kQuarter}, {q[3], -0.32, 0.0, kQuarter},
                       {q[4], 0.0, 0.0, -kQuarter},          {q[5], -0.08, 0.0, 2.0 * kQuarter}};
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (const Row& row : table)
    pose = pose * Eigen::AngleAxisd(row.theta, Eigen::Vector3d::UnitZ()) *
           Eigen::Translation3d(row.a, 0.0, row.d) * Eigen::AngleAxisd(row.alpha, Eigen::Vector3d::UnitX());
  return pose * Eigen::Vector3d(0.0, 0.0, 0.07465);
}

/// Big-endian words out of a string of bytes; throws std::out_of_range past the end.
class BigEndian {
 public:
  explicit BigEndian(std::string bytes) : bytes_(std::move(bytes)) {}
  bool at_end() const { return at_ >= bytes_.size(); }
  std::string raw(std::size_t count) {
    if (count > bytes_.size() - at_) throw std::out_of_range("the recording ends within a message");
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  std::uint64_t word(std::size_t size) {
    std::uint64_t value = 0;
    for (const char c : raw(size)) value = (value << 8U) | static_cast<unsigned char>(c);
    return value;
  }
  std::int64_t int64() { return static_cast<std::int64_t>(word(8)); }
  std::int32_t int32() { return static_cast<std::int32_t>(word(4)); }
  std::int8_t int8() { return static_cast<std::int8_t>(word(1)); }
  double real() { return std::bit_cast<double>(word(8)); }
  std::string text() {
    std::string with_nul = raw(word(4));
    with_nul.pop_back();
    return with_nul;
  }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

namespace recording_detail {

struct Mark {
  std::int64_t begin_us = 0, end_us = 0;
  std::string test, series;
  int direction = 0, repetition = 0;
  double feed = 0.0;
};

struct Streams {
  std::vector<Mark> runs;
  std::vector<double> bar_us, bar_um;
  std::vector<double> joint_us;
  std::vector<Eigen::Matrix<double, 6, 1>> joint_rad;
  struct Reading {
    std::int64_t time_us;
    std::string axis;
    double position_mm, deviation_um;
  };
  std::vector<Reading> readings;
  std::int64_t zero_us = 0;  // times are kept relative to the first mark, so that doubles hold them
};

inline void read_mark(BigEndian& in, std::int64_t time_us, Streams& all) {
  Mark mark;
  mark.test = in.text();
  const int kind = in.int8();
  mark.direction = in.int8();
  mark.repetition = in.int32();
  mark.series = in.text();
  mark.feed = in.real() * 1e-3;
  mark.begin_us = time_us;
  if (kind == 1) all.runs.push_back(mark);
  if (kind == 2) all.runs.back().end_us = time_us;
}

inline void read_message(const std::string& channel, BigEndian in, Streams& all) {
  in.word(8);  // fingerprint
  const std::int64_t time_us = in.int64();
  in.int64();  // seq
  in.text();   // robot
  if (all.zero_us == 0) all.zero_us = time_us;
  const auto since = static_cast<double>(time_us - all.zero_us);
  if (channel == "TEST_MARK") {
    read_mark(in, time_us, all);
  } else if (channel == "BALLBAR") {
    const double period = in.real();
    const int count = in.int32();
    for (int i = 0; i < count; ++i) {
      all.bar_us.push_back(since + i * period);
      all.bar_um.push_back(in.real());
    }
  } else if (channel == "JOINTS") {
    if (in.int32() != 6) throw std::runtime_error("a joint message without six joints");
    Eigen::Matrix<double, 6, 1> q;
    for (int j = 0; j < 6; ++j) q[j] = in.real();
    all.joint_us.push_back(since);
    all.joint_rad.push_back(q);
  } else if (channel == "INTERFEROMETER") {
    const std::string axis = in.text();
    const int count = in.int32();
    const std::size_t first = all.readings.size();
    for (int i = 0; i < count; ++i) all.readings.push_back({time_us, axis, in.real(), 0.0});
    for (int i = 0; i < count; ++i)
      all.readings[first + static_cast<std::size_t>(i)].deviation_um = in.real();
  }
}

inline Streams read_streams(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  BigEndian in(std::string(std::istreambuf_iterator<char>(file), {}));
  Streams all;
  while (!in.at_end()) {
    if (in.word(4) != 0xEDA1DA01U) throw std::runtime_error("no LCM log: " + path.string());
    in.int64();  // event number
    in.int64();  // time of reception
    const std::size_t channel_size = in.word(4);
    const std::size_t data_size = in.word(4);
    const std::string channel = in.raw(channel_size);
    read_message(channel, BigEndian(in.raw(data_size)), all);
  }
  return all;
}

/// Tool point at a time between two joint samples: the joints are interpolated, not the points.
inline Eigen::Vector3d tool_at(double time_us, const Streams& all, std::size_t& after) {
  while (after < all.joint_us.size() && all.joint_us[after] < time_us) ++after;
  if (after == 0 || after == all.joint_us.size())
    return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  const double share = (time_us - all.joint_us[after - 1]) / (all.joint_us[after] - all.joint_us[after - 1]);
  return lr_mate_tool((1.0 - share) * all.joint_rad[after - 1] + share * all.joint_rad[after]);
}

inline RecordedCircle circle_of(const Mark& mark, const Streams& all) {
  RecordedCircle circle{
      mark.test, mark.series, mark.direction, mark.repetition, mark.begin_us, 0.0, mark.feed, {}, {}, {}};
  const auto begin = static_cast<double>(mark.begin_us - all.zero_us);
  const auto end = static_cast<double>(mark.end_us - all.zero_us);
  circle.duration = (end - begin) * 1e-6;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < all.bar_us.size(); ++i)
    if (all.bar_us[i] >= begin && all.bar_us[i] <= end) chosen.push_back(i);
  const auto count = static_cast<Eigen::Index>(chosen.size());
  circle.bar_time.resize(count);
  circle.bar_deviation.resize(count);
  circle.tool.resize(3, count);
  std::size_t after = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::size_t sample = chosen[static_cast<std::size_t>(i)];
    circle.bar_time[i] = (all.bar_us[sample] - begin) * 1e-6;
    circle.bar_deviation[i] = all.bar_um[sample] * 1e-6;
    circle.tool.col(i) = tool_at(all.bar_us[sample], all, after);
  }
  return circle;
}

inline RecordedLine line_of(const Mark& mark, const Streams& all) {
  RecordedLine line{mark.test, "", mark.direction, mark.repetition, {}, {}};
  for (const Streams::Reading& reading : all.readings) {
    if (reading.time_us < mark.begin_us || reading.time_us > mark.end_us) continue;
    line.axis = reading.axis;
    line.position.push_back(reading.position_mm * 1e-3);
    line.deviation.push_back(reading.deviation_um * 1e-6);
  }
  return line;
}

}  // namespace recording_detail

/// @throws std::runtime_error where the file is missing or no such log
inline PaperRecording read_paper_recording(const std::filesystem::path& path) {
  const recording_detail::Streams all = recording_detail::read_streams(path);
  PaperRecording recording;
  for (const recording_detail::Mark& mark : all.runs) {
    if (mark.test == "Y")
      recording.lines.push_back(recording_detail::line_of(mark, all));
    else
      recording.circles.push_back(recording_detail::circle_of(mark, all));
  }
  return recording;
}

}  // namespace ballbar::test

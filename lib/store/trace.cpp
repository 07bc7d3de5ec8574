#include "store/trace.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

// Coding 2: four bytes, the size of the packed form, little-endian; then the packed form through zlib, whose
// checksum finds damage. The packed form is nine counts, then columns. Coding 1 is the same without
// predictions.
//
// Counts are varints (seven bits a byte, low ones first, high bit = more follow): bar samples; angles (0 or
// as bar samples); predictions (likewise); arc begin; arc end; joints; joint samples; torque samples (0 or as
// joint samples); readings.
//
// Columns, empty ones left out: bar time, deviation, angle, prediction; joint time, each joint's position,
// each joint's torque; of the readings axis (one byte each), time, position, deviation.
//
// A column is one byte n and its numbers. n = 0, 1, 2: n-th differences of the numbers in steps, one varint
// each: 0 = NaN, which the differences pass over, else 1 + zigzag. n = 3: IEEE 754, eight bytes each,
// little-endian.

namespace ballbar {

namespace {

using Bytes = std::vector<std::uint8_t>;

// Steps per unit. Whole numbers, so that decoding divides by an exact number: one rounding, and no more.
constexpr double kPerSecond = 1e6;
constexpr double kPerMetre = 1e9;
constexpr double kPerRadian = 1e9;
constexpr double kPerNewtonMetre = 1e3;

constexpr double kMaxSteps = 9007199254740992.0;  // 2^53: whole numbers that a double holds
constexpr int kMaxDifferences = 2;
constexpr std::size_t kMaxPackedBytes = 9 * kMaxTraceValues + 1000;  // steps below 2^53: at most 9 bytes each
constexpr std::uint8_t kExact = 3;

std::uint64_t zigzag(std::uint64_t v) { return (v << 1) ^ (0 - (v >> 63)); }
std::uint64_t unzigzag(std::uint64_t v) { return (v >> 1) ^ (0 - (v & 1)); }

void put_varint(Bytes& out, std::uint64_t v) {
  for (; v >= 0x80; v >>= 7) out.push_back(static_cast<std::uint8_t>(v | 0x80));
  out.push_back(static_cast<std::uint8_t>(v));
}

/// n-th differences, forwards and back. Unsigned: wrapping is defined, and undoes itself.
class Differences {
 public:
  explicit Differences(int n) : n_(n) {}
  std::uint64_t forward(std::uint64_t v) {
    for (int i = 0; i < n_; ++i) {
      const std::uint64_t difference = v - last_[i];
      last_[i] = v;
      v = difference;
    }
    return v;
  }
  std::uint64_t back(std::uint64_t v) {
    for (int i = n_ - 1; i >= 0; --i) v = last_[i] += v;
    return v;
  }

 private:
  int n_;
  std::uint64_t last_[kMaxDifferences] = {};
};

Bytes differences(const std::vector<double>& values, double per_unit, int n) {
  Bytes out{static_cast<std::uint8_t>(n)};
  Differences state(n);
  for (const double v : values) {
    if (std::isnan(v)) {
      out.push_back(0);
    } else {
      put_varint(out, 1 + zigzag(state.forward(static_cast<std::uint64_t>(std::llround(v * per_unit)))));
    }
  }
  return out;
}

Bytes exact(const std::vector<double>& values) {
  Bytes out{kExact};
  for (const double v : values) {
    const auto bits = std::bit_cast<std::uint64_t>(v);
    for (int shift = 0; shift < 64; shift += 8) out.push_back(static_cast<std::uint8_t>(bits >> shift));
  }
  return out;
}

void put_column(Bytes& out, const std::vector<double>& values, double per_unit) {
  if (values.empty()) return;
  const bool fits = std::all_of(values.begin(), values.end(), [per_unit](double v) {
    return std::isnan(v) || std::abs(v * per_unit) < kMaxSteps;
  });
  // Smooth columns shrink with each difference taken, noisy ones grow: the shortest says which it is.
  Bytes best = fits ? differences(values, per_unit, 0) : exact(values);
  for (int n = 1; fits && n <= kMaxDifferences; ++n) {
    Bytes other = differences(values, per_unit, n);
    if (other.size() < best.size()) best = std::move(other);
  }
  out.insert(out.end(), best.begin(), best.end());
}

[[noreturn]] void damaged(const char* what) {
  throw std::runtime_error(std::string("the stored trace is damaged: ") + what);
}

class Reader {
 public:
  explicit Reader(const Bytes& bytes) : at_(bytes.data()), end_(bytes.data() + bytes.size()) {}

  std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }

  std::uint8_t byte() {
    if (at_ == end_) damaged("it ends too early");
    return *at_++;
  }

  std::uint64_t varint() {
    std::uint64_t v = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const std::uint8_t b = byte();
      if (shift == 63 && b > 1) break;
      v |= static_cast<std::uint64_t>(b & 0x7f) << shift;
      if (b < 0x80) return v;
    }
    damaged("a number is too long");
  }

  std::size_t count() {
    const std::uint64_t n = varint();
    if (n > kMaxTraceValues) damaged("an impossible count");
    return static_cast<std::size_t>(n);
  }

  std::vector<double> column(std::size_t n, double per_unit) {
    if (n == 0) return {};
    const std::uint8_t mode = byte();
    if (mode > kExact) damaged("an unknown kind of column");
    if (n > left() / (mode == kExact ? 8 : 1)) damaged("a column ends too early");
    std::vector<double> values(n);
    Differences state(mode);
    for (double& v : values) v = mode == kExact ? exact_number() : number(state, per_unit);
    return values;
  }

 private:
  double exact_number() {
    std::uint64_t bits = 0;
    for (int shift = 0; shift < 64; shift += 8) bits |= static_cast<std::uint64_t>(byte()) << shift;
    return std::bit_cast<double>(bits);
  }

  double number(Differences& state, double per_unit) {
    const std::uint64_t code = varint();
    if (code == 0) return std::numeric_limits<double>::quiet_NaN();
    const auto steps = static_cast<std::int64_t>(state.back(unzigzag(code - 1)));
    const auto value = static_cast<double>(steps);
    if (std::abs(value) >= kMaxSteps) damaged("an impossible number");
    return value / per_unit;
  }

  const std::uint8_t* at_;
  const std::uint8_t* end_;
};

/// One joint of a row-major table.
std::vector<double> joint_of(const std::vector<double>& table, std::size_t joints, std::size_t j) {
  std::vector<double> column;
  column.reserve(table.size() / joints);
  for (std::size_t i = j; i < table.size(); i += joints) column.push_back(table[i]);
  return column;
}

std::vector<double> field_of(const std::vector<InterferometerReading>& readings,
                             double InterferometerReading::*field) {
  std::vector<double> column;
  column.reserve(readings.size());
  for (const InterferometerReading& r : readings) column.push_back(r.*field);
  return column;
}

void check_shapes(const Trace& t) {
  const std::size_t bar = t.bar_time.size();
  const std::size_t cells = t.joint_time.size() * static_cast<std::size_t>(std::max(t.joints, 0));
  if (t.bar_deviation.size() != bar || (!t.angle.empty() && t.angle.size() != bar) ||
      (!t.predicted.empty() && t.predicted.size() != bar) || t.arc_begin > t.arc_end || t.arc_end > bar)
    throw std::invalid_argument("trace: deviation, angle, prediction and arc must fit the bar's times");
  if (t.joints < 0 || (t.joints == 0 && !t.joint_time.empty()) || t.joint_position.size() != cells ||
      (!t.joint_torque.empty() && t.joint_torque.size() != cells))
    throw std::invalid_argument("trace: joint positions and torques must be times x joints");
  if (static_cast<std::size_t>(t.joints) > kMaxTraceValues ||
      4 * bar + t.joint_time.size() + 2 * cells + 4 * t.readings.size() > kMaxTraceValues)
    throw std::invalid_argument("trace: more than " + std::to_string(kMaxTraceValues) + " numbers");
}

Bytes pack(const Trace& t) {
  const auto joints = static_cast<std::size_t>(t.joints);
  Bytes out;
  for (const std::size_t n :
       {t.bar_time.size(), t.angle.size(), t.predicted.size(), t.arc_begin, t.arc_end, joints,
        t.joint_time.size(), t.joint_torque.empty() ? 0 : t.joint_time.size(), t.readings.size()})
    put_varint(out, n);
  put_column(out, t.bar_time, kPerSecond);
  put_column(out, t.bar_deviation, kPerMetre);
  put_column(out, t.angle, kPerRadian);
  put_column(out, t.predicted, kPerMetre);
  put_column(out, t.joint_time, kPerSecond);
  for (std::size_t j = 0; j < joints; ++j) put_column(out, joint_of(t.joint_position, joints, j), kPerRadian);
  for (std::size_t j = 0; j < joints; ++j)
    put_column(out, joint_of(t.joint_torque, joints, j), kPerNewtonMetre);
  for (const InterferometerReading& r : t.readings) out.push_back(static_cast<std::uint8_t>(r.axis));
  put_column(out, field_of(t.readings, &InterferometerReading::time), kPerSecond);
  put_column(out, field_of(t.readings, &InterferometerReading::position), kPerMetre);
  put_column(out, field_of(t.readings, &InterferometerReading::deviation), kPerMetre);
  return out;
}

std::vector<double> read_joints(Reader& in, std::size_t rows, std::size_t joints, double per_unit) {
  if (rows == 0 || joints == 0) return {};
  if (rows > in.left() / joints) damaged("joint samples end too early");
  std::vector<double> table(rows * joints);
  for (std::size_t j = 0; j < joints; ++j) {
    const std::vector<double> column = in.column(rows, per_unit);
    for (std::size_t i = 0; i < rows; ++i) table[i * joints + j] = column[i];
  }
  return table;
}

void read_readings(Reader& in, std::size_t n, std::vector<InterferometerReading>& readings) {
  if (n > in.left()) damaged("readings end too early");
  readings.resize(n);
  for (InterferometerReading& r : readings) r.axis = static_cast<char>(in.byte());
  const std::vector<double> time = in.column(n, kPerSecond);
  const std::vector<double> position = in.column(n, kPerMetre);
  const std::vector<double> deviation = in.column(n, kPerMetre);
  for (std::size_t i = 0; i < n; ++i) readings[i] = {readings[i].axis, time[i], position[i], deviation[i]};
}

Trace unpack(int coding, const Bytes& packed) {
  Reader in(packed);
  Trace t;
  const std::size_t bar = in.count();
  const std::size_t angles = in.count();
  const std::size_t predictions = coding == 1 ? 0 : in.count();
  t.arc_begin = in.count();
  t.arc_end = in.count();
  const std::size_t joints = in.count();
  const std::size_t rows = in.count();
  const std::size_t torque_rows = in.count();
  const std::size_t readings = in.count();
  if ((angles != 0 && angles != bar) || (predictions != 0 && predictions != bar) || t.arc_begin > t.arc_end ||
      t.arc_end > bar)
    damaged("impossible counts");
  if ((joints == 0 && rows != 0) || (torque_rows != 0 && torque_rows != rows)) damaged("impossible counts");
  t.joints = static_cast<int>(joints);
  t.bar_time = in.column(bar, kPerSecond);
  t.bar_deviation = in.column(bar, kPerMetre);
  t.angle = in.column(angles, kPerRadian);
  t.predicted = in.column(predictions, kPerMetre);
  t.joint_time = in.column(rows, kPerSecond);
  t.joint_position = read_joints(in, rows, joints, kPerRadian);
  t.joint_torque = read_joints(in, torque_rows, joints, kPerNewtonMetre);
  read_readings(in, readings, t.readings);
  if (in.left() != 0) damaged("there are bytes left over");
  return t;
}

}  // namespace

Trace make_trace(const Run& run, const RunResult& result) {
  return {run.bar_time,       run.bar_deviation, result.angle, result.predicted,
          result.arc_begin,   result.arc_end,    run.joints,   run.joint_time,
          run.joint_position, run.joint_torque,  run.readings};
}

Bytes encode(const Trace& trace) {
  check_shapes(trace);
  const Bytes packed = pack(trace);
  Bytes out(4 + compressBound(packed.size()));
  for (int i = 0; i < 4; ++i)
    out[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(packed.size() >> (8 * i));
  uLongf size = out.size() - 4;
  if (compress2(out.data() + 4, &size, packed.data(), packed.size(), Z_DEFAULT_COMPRESSION) != Z_OK)
    throw std::runtime_error("no memory to compress a trace");
  out.resize(4 + size);
  if (out.size() > kMaxTraceBytes) throw std::invalid_argument("trace: more bytes than the stated maximum");
  return out;
}

Trace decode(int coding, const Bytes& bytes) {
  if (coding < 1 || coding > kTraceCoding)
    throw std::runtime_error("the stored trace has coding " + std::to_string(coding) +
                             ", which this version does not know");
  if (bytes.size() < 4 || bytes.size() > kMaxTraceBytes) damaged("its size is impossible");
  std::size_t size = 0;
  for (std::size_t i = 0; i < 4; ++i) size |= static_cast<std::size_t>(bytes[i]) << (8 * i);
  // zlib shrinks to 1/1032 at best: a small damaged blob cannot ask for much memory, nor a large one for more
  // than ours.
  if (size > std::min(1032 * bytes.size(), kMaxPackedBytes)) damaged("its size is impossible");
  Bytes packed(size);
  uLongf unpacked = size;
  uLong used = bytes.size() - 4;
  if (uncompress2(packed.data(), &unpacked, bytes.data() + 4, &used) != Z_OK || unpacked != size ||
      used != bytes.size() - 4)
    damaged("its checksum does not fit");
  return unpack(coding, packed);
}

}  // namespace ballbar

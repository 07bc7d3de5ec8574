#include "fuzz/targets.hpp"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "bus/assembler.hpp"
#include "bus/decode.hpp"
#include "bus/log_file.hpp"
#include "core/error.hpp"
#include "daemon/config.hpp"
#include "files/b5r.hpp"
#include "files/csv.hpp"
#include "files/poses_csv.hpp"
#include "kinematics/robot_model.hpp"
#include "rules/rule.hpp"
#include "rules/sandbox.hpp"
#include "store/trace.hpp"

// urdfdom keeps some 600 bytes of a robot where two joints have one child, or whose links form a ring.
extern "C" const char* __lsan_default_suppressions() { return "leak:liburdfdom_model"; }

namespace ballbar::fuzz {
namespace {

std::string text_of(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

/// The bytes as a file, for what reads only files.
class File {
 public:
  File(Bytes bytes, const char* end) {
    const char* folder = std::filesystem::exists("/dev/shm") ? "/dev/shm" : "/tmp";
    path_ = std::string(folder) + "/ballbar-fuzz-" + std::to_string(getpid()) + end;
    std::ofstream file(path_, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  ~File() { std::filesystem::remove(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

void demand(bool holds, const char* what) {
  if (!holds) throw std::logic_error(what);
}

RobotSpec robot() {
  RobotSpec spec;
  spec.name = "r1";
  for (const char* name : {"A", "Y"}) {
    TestSpec& test = spec.tests.emplace_back();
    test.name = name;
    if (*name == 'Y') test.kind = TestKind::kLine;
  }
  return spec;
}

/// Small numbers out of the bytes, zeros behind their end.
class Numbers {
 public:
  explicit Numbers(Bytes bytes) : bytes_(bytes) {}
  bool end() const { return at_ >= bytes_.size(); }
  int next() { return end() ? 0 : bytes_[at_++]; }

 private:
  Bytes bytes_;
  std::size_t at_ = 0;
};

}  // namespace

void message(Bytes bytes) {
  if (bytes.empty()) return;
  const auto channel = static_cast<Channel>(bytes[0] % kInputChannels.size());
  const Decoded decoded = decode(channel, bytes.subspan(1));
  if (const auto* sample = std::get_if<Sample>(&decoded))
    demand(channel_of(*sample) == channel, "a sample of another channel");
}

void marks(Bytes bytes) {
  AssemblerLimits limits;
  limits.bar_samples = limits.joint_samples = limits.readings = 200;
  Assembler assembler({robot()}, limits);
  std::vector<Run> finished;
  std::array<std::int64_t, 4> seq{};
  std::int64_t time_us = 1'700'000'000'000'000;
  std::int64_t arrival_us = 0;
  for (Numbers numbers(bytes); !numbers.end();) {
    const int kind = numbers.next();
    const int step = numbers.next() - 64;
    time_us += std::int64_t{step} * step * step * 1000;
    arrival_us += 1000 + std::int64_t{numbers.next()} * 10'000;
    const auto channel = static_cast<std::size_t>(kind % 4);
    seq[channel] += numbers.next() - 100;
    const SampleHeader header{time_us, seq[channel], kind % 64 == 63 ? "stranger" : "r1"};
    const int value = numbers.next();
    const std::vector<double> many(static_cast<std::size_t>(1 + value % 50), 1e-6 * value);
    if (channel == 0) assembler.take(BallbarBlock{header, 0.004, many}, arrival_us, finished);
    if (channel == 1) assembler.take(InterferometerBlock{header, 'X', many, many}, arrival_us, finished);
    if (channel == 2)
      assembler.take(
          JointSample{header, std::vector<double>(static_cast<std::size_t>(1 + value % 3), 0.1), {}},
          arrival_us, finished);
    if (channel == 3)
      assembler.take(TestMark{header,
                              value % 8 == 7   ? "Q"
                              : value % 2 == 0 ? "A"
                                               : "Y",
                              static_cast<Mark>(1 + value % 3),
                              value / 8 % 3 - 1,
                              value / 32,
                              "s",
                              0.05,
                              0.5,
                              {}},
                     arrival_us, finished);
    if (kind / 4 % 8 == 7) assembler.tick(arrival_us, finished);
    if (kind / 4 % 16 == 14) assembler.receiver_restarted();
  }
  assembler.close_all(RunEnd::kInterrupted, finished);
  demand(assembler.open_runs() == 0, "a run is open behind the end");
  for (const Run& run : finished) {
    demand(run.bar_time.size() == run.bar_deviation.size(), "bar samples without a time");
    demand(run.joint_position.size() == run.joint_time.size() * static_cast<std::size_t>(run.joints),
           "joints of another count");
    demand(
        run.bar_time.size() <= limits.bar_samples + 50 && run.joint_time.size() <= limits.joint_samples + 50,
        "more than the stated maximum");
  }
}

void log_file(Bytes bytes) {
  const File file(bytes, ".lcm");
  try {
    const LogFile log = inspect_log(file.path());
    demand(log.good_bytes <= log.bytes, "more good bytes than there are");
    std::int64_t heard = 0;
    read_log(log, [&](Channel channel, std::span<const std::uint8_t> event, std::int64_t) {
      decode(channel, event);
      ++heard;
    });
    demand(heard <= log.events, "more events than were inspected");
  } catch (const Error&) {
  }
}

void config(Bytes bytes) {
  const File file(bytes, ".toml");
  try {
    load_config(file.path());
  } catch (const Error&) {
  }
}

void urdf(Bytes bytes) {
  try {
    const RobotModel model(text_of(bytes), "base", "tcp", JointConvention::kSerial);
    model.forward(std::vector<double>(static_cast<std::size_t>(model.joints()), 0.1));
  } catch (const Error&) {
  }
}

void rule(Bytes bytes) {
  try {
    const Rule parsed = parse_rule({"fuzz.lua", text_of(bytes)});
    Record record;
    record.robot = "r1";
    record.test = "A";
    record.kind = parsed.kind;
    record.status = "ok";
    record.direction = 1;
    record.values["ovality_um"] = {30.0, 0.5};
    History history;
    history.recent = {record};
    if (applies(parsed, record)) judge(parsed, record, history);
  } catch (const ScriptError&) {
  }
}

void b5r(Bytes bytes) {
  try {
    read_b5r(text_of(bytes));
  } catch (const Error&) {
  }
}

void csv(Bytes bytes) {
  CsvOptions options;
  options.unit = "um";
  try {
    read_csv(text_of(bytes), options);
  } catch (const Error&) {
  }
}

void poses(Bytes bytes) {
  try {
    read_poses(text_of(bytes), 2);
  } catch (const Error&) {
  }
}

void trace(Bytes bytes) {
  if (bytes.empty()) return;
  try {
    const Trace decoded = decode(1 + bytes[0] % 2, {bytes.begin() + 1, bytes.end()});
    demand(decoded.bar_time.size() == decoded.bar_deviation.size(), "bar samples without a time");
  } catch (const std::runtime_error&) {
  }
}

}  // namespace ballbar::fuzz

#include "bus/log_file.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>

#include "core/error.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kHeaderBytes = 28;
constexpr std::uint64_t kMaxChannelBytes = 1000;  // as liblcm reads

std::uint64_t big_endian(const char* bytes, int size) {
  std::uint64_t value = 0;
  for (int i = 0; i < size; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

}  // namespace

LogFile inspect_log(const std::string& path) {
  const auto refuse = [&path](const std::string& why) { return Error(Cause::kInput, path + ": " + why); };
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw refuse("is a folder; give an LCM log, as lcm-logger writes it");
  std::ifstream file(path, std::ios::binary);
  const auto size = std::filesystem::file_size(path, error);
  if (!file || error) throw refuse("cannot be read; is the path right?");
  LogFile log{path, 0, static_cast<std::int64_t>(size), 0, 0.0};
  std::int64_t first_us = 0;
  std::array<char, kHeaderBytes> head{};
  // sync 4, event number 8, time 8, channel length 4, data length 4; then channel and data (LCM's log format)
  while (file.seekg(log.good_bytes) && file.read(head.data(), kHeaderBytes)) {
    const std::uint64_t channel = big_endian(head.data() + 20, 4);
    const std::uint64_t data = big_endian(head.data() + 24, 4);
    const auto time_us = static_cast<std::int64_t>(big_endian(head.data() + 12, 8));
    if (big_endian(head.data(), 4) != kLogSync || channel == 0 || channel >= kMaxChannelBytes) break;
    if (time_us < 0 || time_us > kLatestTimeUs) break;
    const std::int64_t next = log.good_bytes + kHeaderBytes + static_cast<std::int64_t>(channel + data);
    if (next > log.bytes) break;
    if (log.events++ == 0) first_us = time_us;
    log.recorded_s = static_cast<double>(time_us - first_us) * 1e-6;
    log.good_bytes = next;
  }
  if (log.events == 0) throw refuse("is not an LCM log; give a file that lcm-logger wrote");
  return log;
}

void read_log(const LogFile& log, const RawHandler& handler) {
  lcm::LogFile file(log.path, "r");
  for (std::int64_t i = 0; i < log.events; ++i) {
    const lcm::LogEvent* event = file.good() ? file.readNextEvent() : nullptr;
    if (event == nullptr)
      throw Error(Cause::kInput, log.path + ": event " + std::to_string(i + 1) + " of " +
                                     std::to_string(log.events) + " cannot be read any more");
    const auto* info = std::find_if(kInputChannels.begin(), kInputChannels.end(),
                                    [&](const ChannelInfo& known) { return known.name == event->channel; });
    if (info == kInputChannels.end()) continue;
    handler(info->channel,
            {static_cast<const std::uint8_t*>(event->data), static_cast<std::size_t>(event->datalen)},
            event->timestamp);
  }
}

}  // namespace ballbar

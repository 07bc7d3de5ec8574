#include "bus/log_writer.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>

#include "bus/log_file.hpp"
#include "core/error.hpp"

namespace ballbar {
namespace {

void put(std::string& bytes, std::uint64_t value, int size) {
  for (int i = size - 1; i >= 0; --i) bytes += static_cast<char>(value >> (8 * i) & 0xFFU);
}

}  // namespace

LogWriter::LogWriter(const std::string& path) : path_(path), draft_(path + ".XXXXXX") {
  if (path.find('?') != std::string::npos)
    throw Error(Cause::kInput, path + ": has a '?' in its name, which LCM cannot open; choose another");
  struct stat there {};
  if (::stat(path.c_str(), &there) == 0 && S_ISDIR(there.st_mode))
    throw Error(Cause::kInput, path + ": is a folder; give the log a name in it");
  const int descriptor = ::mkostemp(draft_.data(), O_CLOEXEC);
  if (descriptor < 0) fail();
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(descriptor, 0666 & ~mask);  // as any other file that the user makes
  file_ = ::fdopen(descriptor, "wb");
}

LogWriter::~LogWriter() {
  if (!file_) return;
  std::fclose(file_);
  ::unlink(draft_.c_str());
}

void LogWriter::fail() const {
  throw Error(Cause::kWorld, path_ + ": cannot be written: " + std::strerror(errno));
}

void LogWriter::write(const Encoded& message, std::int64_t arrival_us) {
  // LCM's log format, big-endian: sync, event number, time, lengths of channel and data, channel, data
  const std::string_view channel = channel_name(message.channel);
  std::string head;
  put(head, kLogSync, 4);
  put(head, static_cast<std::uint64_t>(events_++), 8);
  put(head, static_cast<std::uint64_t>(arrival_us), 8);
  put(head, channel.size(), 4);
  put(head, message.bytes.size(), 4);
  head += channel;
  if (std::fwrite(head.data(), 1, head.size(), file_) != head.size() ||
      std::fwrite(message.bytes.data(), 1, message.bytes.size(), file_) != message.bytes.size())
    fail();
}

void LogWriter::keep() {
  std::FILE* file = file_;
  file_ = nullptr;
  const bool written = std::fclose(file) == 0;
  if (written && ::rename(draft_.c_str(), path_.c_str()) == 0) return;
  const int reason = errno;
  ::unlink(draft_.c_str());
  errno = reason;
  fail();
}

}  // namespace ballbar

#include "daemon/log.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "daemon/clock.hpp"

namespace ballbar {
namespace {

void write_line(Priority priority, const std::string& text) {
  static const bool journal = std::getenv("JOURNAL_STREAM") != nullptr;
  const std::string prefix = journal ? "<" + std::to_string(static_cast<int>(priority)) + ">" : "";
  std::fputs((prefix + text + "\n").c_str(), stderr);
}

}  // namespace

std::optional<std::int64_t> LineBudget::take(std::uint64_t now_us) {
  if (left_ == kBurst) filled_us_ = now_us;
  const std::uint64_t more = (now_us - filled_us_) / kEveryUs;
  filled_us_ += more * kEveryUs;
  left_ = std::min(kBurst, left_ + static_cast<std::int64_t>(more));
  if (left_ == 0) {
    ++left_out_;
    return std::nullopt;
  }
  --left_;
  return std::exchange(left_out_, 0);
}

void log_line(Priority priority, std::string text) {
  static LineBudget of_errors, of_others;
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  const auto left_out = (priority == Priority::kError ? of_errors : of_others).take(steady_us());
  if (!left_out) return;
  if (*left_out > 0)
    write_line(priority, std::to_string(*left_out) + " lines were left out here: too many at once");
  write_line(priority, text);
}

}  // namespace ballbar

#include "report/gnuplot_text.hpp"

#include <array>
#include <charconv>
#include <cstddef>

#include "report/utf8.hpp"

namespace ballbar {
namespace {

constexpr std::size_t kLongestText = 160;  // characters; wider than any picture of ours

}  // namespace

std::string gnuplot_quoted(std::string_view text) {
  std::string quoted = "'";
  for (std::size_t count = 0; !text.empty(); ++count) {
    if (count == kLongestText) {
      quoted += "…";
      break;
    }
    const Character c = first_character(text);
    const std::size_t bytes = c.bytes == 0 ? 1 : c.bytes;
    if (c.bytes == 0) {
      quoted += "�";
    } else if (is_unprintable(c.code)) {
      quoted += ' ';
    } else if (c.code == '\'') {
      quoted += "’";  // gnuplot 5.4 does not take a doubled quote everywhere
    } else {
      quoted += text.substr(0, bytes);
    }
    text.remove_prefix(bytes);
  }
  return quoted + "'";
}

std::string plain_number(double value, int decimals) {
  std::array<char, 400> buffer{};  // the longest double has 309 digits before the point
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, decimals);
  std::string digits(buffer.data(), end.ptr);
  if (digits.find('.') != std::string::npos) {
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.back() == '.') digits.pop_back();
  }
  return digits == "-0" ? "0" : digits;
}

}  // namespace ballbar

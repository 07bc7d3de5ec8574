#include "report/gnuplot_text.hpp"

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>

namespace ballbar {
namespace {

constexpr std::size_t kLongestText = 160;  // characters; wider than any picture of ours

struct Character {
  std::size_t bytes = 0;  // 0: not UTF-8
  std::uint32_t code = 0;
};

/// The character at the front of `text`, by the table of RFC 3629: no overlong forms, no surrogates.
Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return {1, lead};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {};
  std::uint32_t code = lead & (0xFFU >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return {};
    code = (code << 6U) | (byte(i) & 0x3FU);
  }
  constexpr std::array<std::uint32_t, 5> smallest{0, 0, 0x80, 0x800, 0x10000};
  if (code < smallest.at(bytes) || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return {};
  return {bytes, code};
}

bool is_control(std::uint32_t code) { return code < 0x20 || (code >= 0x7F && code < 0xA0); }

/// Line and paragraph separators, and what XML 1.0 does not allow.
bool is_unfit(std::uint32_t code) { return code == 0x2028 || code == 0x2029 || (code & 0xFFFEU) == 0xFFFEU; }

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
    } else if (is_control(c.code) || is_unfit(c.code)) {
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

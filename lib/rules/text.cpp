#include "rules/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace ballbar {
namespace {

constexpr const char* kNameCharacters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";

}  // namespace

std::vector<std::string> placeholders(const std::string& text) {
  std::vector<std::string> names;
  std::size_t at = 0;
  while ((at = text.find_first_of("{}", at)) != std::string::npos) {
    const std::size_t end = text.find_first_not_of(kNameCharacters, at + 1);
    if (text[at] == '}' || end == std::string::npos || text[end] != '}' || end == at + 1)
      throw std::invalid_argument("braces enclose one name each, as in {ovality_um}");
    names.push_back(text.substr(at + 1, end - at - 1));
    at = end + 1;
  }
  return names;
}

std::string fill(const std::string& text, const std::function<std::string(const std::string&)>& value_of) {
  std::string filled;
  std::size_t at = 0;
  for (const std::string& name : placeholders(text)) {
    const std::size_t brace = text.find('{', at);
    filled += text.substr(at, brace - at) + value_of(name);
    at = brace + name.size() + 2;
  }
  filled += text.substr(at);
  std::replace_if(
      filled.begin(), filled.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return filled;
}

std::string text_of_line(const std::string& source, int line) {
  constexpr std::size_t kShown = 200;
  std::size_t begin = 0;
  for (int i = 1; i < line && begin != std::string::npos; ++i) {
    begin = source.find('\n', begin);
    if (begin != std::string::npos) ++begin;
  }
  if (line <= 0 || begin == std::string::npos) return "";
  std::string text = source.substr(begin, source.find('\n', begin) - begin);
  while (!text.empty() && text.back() == '\r') text.pop_back();
  const std::size_t indent = text.find_first_not_of(" \t");
  return indent == std::string::npos ? "" : text.substr(indent, kShown);
}

std::string short_number(double value) {
  std::array<char, 40> buffer{};
  if (value == std::trunc(value) && std::abs(value) < 1e15) {
    std::snprintf(buffer.data(), buffer.size(), "%.0f", value + 0.0);  // + 0.0: no "-0"
  } else if (std::abs(value) >= 10.0 && std::abs(value) < 1e15) {
    std::snprintf(buffer.data(), buffer.size(), "%.1f", value);
  } else {
    std::snprintf(buffer.data(), buffer.size(), "%.3g", value);
  }
  return buffer.data();
}

}  // namespace ballbar

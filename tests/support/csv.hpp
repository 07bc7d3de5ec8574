#pragma once
/// CSV as RFC 4180 has it, for tests: fields in quotes may hold commas, line breaks and doubled quotes.

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace ballbar::test {

using CsvRow = std::map<std::string, std::string>;  ///< by the name in the first line

/// @throws std::runtime_error where a row has more or fewer fields than the first line
inline std::vector<CsvRow> parse_csv(const std::string& text) {
  std::vector<std::vector<std::string>> lines(1, std::vector<std::string>(1));
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    std::string& field = lines.back().back();
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      field += text[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (quoted || (c != ',' && c != '\n')) {
      field += c;
    } else if (c == ',') {
      lines.back().emplace_back();
    } else if (i + 1 < text.size()) {
      lines.emplace_back(1);
    }
  }
  std::vector<CsvRow> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].size() != lines[0].size())
      throw std::runtime_error("CSV row " + std::to_string(i) + " has " + std::to_string(lines[i].size()) +
                               " fields, not " + std::to_string(lines[0].size()));
    CsvRow& row = rows.emplace_back();
    for (std::size_t k = 0; k < lines[i].size(); ++k) row[lines[0][k]] = lines[i][k];
  }
  return rows;
}

}  // namespace ballbar::test

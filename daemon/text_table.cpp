#include "daemon/text_table.hpp"

#include <algorithm>

#include "report/utf8.hpp"

namespace ballbar {

std::string text_table(const std::vector<std::vector<std::string>>& rows, std::size_t left) {
  std::vector<std::size_t> width;
  for (const auto& row : rows) {
    width.resize(std::max(width.size(), row.size()), 0);
    for (std::size_t k = 0; k < row.size(); ++k) width[k] = std::max(width[k], characters_of(row[k]));
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k) {
      const std::string fill(width[k] - characters_of(row[k]), ' ');
      line += (k == 0 ? "  " : "   ") + (k < left ? row[k] + fill : fill + row[k]);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

}  // namespace ballbar

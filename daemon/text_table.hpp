#pragma once
/// Tables for a terminal.

#include <string>
#include <vector>

namespace ballbar {

/// Columns, each as wide as its widest cell, the first `left` ones to the left; the first row is the heading.
/// Each row ends with a line break and without blanks.
std::string text_table(const std::vector<std::vector<std::string>>& rows, std::size_t left);

}  // namespace ballbar

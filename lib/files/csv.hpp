#pragma once
/// Readings of a bar or an interferometer in CSV, by a map of columns.

#include <string>
#include <string_view>
#include <vector>

namespace ballbar {

/// Which column holds a quantity, and in which unit: "deviation_um=2", "position_mm=Position (mm)".
struct CsvColumn {
  std::string quantity;  ///< "time", "position", "deviation" or "axis"
  std::string unit;      ///< "" where not stated
  std::string column;    ///< its number from 1, or its name in the first line
};

/// @param text  "QUANTITY[_UNIT]=COLUMN", separated by commas
/// @throws Error(kInput) for another form, an unknown quantity or unit, or a quantity twice
std::vector<CsvColumn> csv_columns_from(const std::string& text);

struct CsvOptions {
  std::vector<CsvColumn> columns;  ///< empty: the first line has names as "deviation_um"
  std::string unit;                ///< of the deviation, where neither column nor name states it
  char separator = '\0';  ///< '\0': tab, semicolon or comma, the first of them that the first line has
  char decimal = '.';     ///< '.' or ','
  int skip = 0;           ///< lines before the first one that counts
};

/// SI. All that are there have one entry per row.
struct CsvReadings {
  std::vector<double> deviation;  ///< [m]
  std::vector<double> time;       ///< [s] empty: no such column
  std::vector<double> position;   ///< [m] likewise
  std::vector<char> axis;         ///< 'X', 'Y' or 'Z'; likewise
};

/// Empty lines and lines that begin with # are passed over. Fields may stand in quotes, but not over several
/// lines. Where all columns are given by number, a first line that is not numbers is taken as names.
/// @param bytes  of the whole file, UTF-8
/// @throws Error(kInput) with line: what is wrong and what to do
CsvReadings read_csv(std::string_view bytes, const CsvOptions& options);

}  // namespace ballbar

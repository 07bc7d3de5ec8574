#include "files/csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "core/error.hpp"
#include "files/b5r.hpp"
#include "files/numbers.hpp"
#include "files/text.hpp"

namespace ballbar {
namespace {

constexpr std::array<std::string_view, 4> kQuantities{"time", "position", "deviation", "axis"};

/// SI per unit of that quantity; nothing for a unit that it cannot have.
std::optional<double> factor_of(std::string_view quantity, std::string_view unit) {
  return quantity == "time" ? seconds_per(unit) : metres_per(unit);
}

/// "deviation_um" into quantity and unit; nothing for a name that is not of this form.
std::optional<CsvColumn> column_named(std::string_view name) {
  for (const std::string_view quantity : kQuantities) {
    if (name == quantity) return CsvColumn{std::string(quantity), "", ""};
    if (quantity == "axis" || !name.starts_with(quantity) || name[quantity.size()] != '_') continue;
    const std::string_view unit = name.substr(quantity.size() + 1);
    if (factor_of(quantity, unit)) return CsvColumn{std::string(quantity), std::string(unit), ""};
  }
  return std::nullopt;
}

struct Line {
  std::size_t number = 0;  ///< in the file, from 1
  std::string_view text;
};

std::vector<Line> lines_of(std::string_view bytes, int skip) {
  std::vector<Line> lines;
  std::size_t number = 0;
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    ++number;
    if (end == std::string_view::npos && !trimmed(bytes).empty())
      throw refused("line " + std::to_string(number) +
                    ": has no end: is the file cut short? If not, add a line break");
    const std::string_view text = trimmed(bytes.substr(0, end));
    if (number > static_cast<std::size_t>(skip) && !text.empty() && text.front() != '#')
      lines.push_back({number, bytes.substr(0, end)});
    bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + 1);
    if (lines.size() > kMaxReadings + 1)
      throw refused("has more than " + std::to_string(kMaxReadings) + " rows");
  }
  return lines;
}

/// The fields of a line. Throws where a quote is not closed.
std::vector<std::string> fields_of(const Line& line, char separator) {
  std::vector<std::string> fields(1);
  bool open = false;
  const std::string_view text = line.text;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (open && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      fields.back() += '"';
      ++i;
    } else if (c == '"') {
      open = !open;
    } else if (c == separator && !open) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  if (open) throw refused("line " + std::to_string(line.number) + ": a quote is not closed");
  for (std::string& field : fields) field = std::string(trimmed(field));
  return fields;
}

/// A column that was found in the file.
struct Found {
  CsvColumn column;
  std::size_t index = 0;
  double factor = 1.0;  ///< SI per unit
};

std::optional<std::size_t> as_number(const std::string& column) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(column.data(), column.data() + column.size(), number);
  if (error != std::errc() || end != column.data() + column.size() || number < 1 || number > 10'000)
    return std::nullopt;
  return number;
}

std::size_t index_of(const std::string& name, const std::vector<std::string>& names) {
  const auto count = std::count(names.begin(), names.end(), name);
  if (count == 1)
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  if (count > 1)
    throw refused(std::to_string(count) + " columns are named " + quoted(name) + "; give its number");
  std::string all;
  for (const std::string& known : names) all += (all.empty() ? "" : ", ") + quoted(known);
  throw refused("no column is named " + quoted(name) + "; there are " + all.substr(0, 300));
}

/// The unit from the name or from --unit, which must not say two things.
double factor_for(const CsvColumn& column, const std::string& given) {
  if (column.quantity == "axis") return 1.0;
  std::string unit = column.unit;
  if (column.quantity == "deviation" && !given.empty()) {
    if (!unit.empty() && unit != given)
      throw refused("the deviation is in " + unit + " by the name of its column, and in " + given +
                    " by --unit; which?");
    unit = given;
  }
  if (unit.empty())
    throw refused("the unit of the " + column.quantity + " is not stated; name the column " +
                  column.quantity + "_UNIT" +
                  (column.quantity == "deviation" ? " or give --unit" : " with --columns") + ", UNIT being " +
                  (column.quantity == "time" ? kTimeUnits : kLengthUnits));
  const std::optional<double> factor = factor_of(column.quantity, unit);
  if (!factor) throw refused(quoted(unit) + " is no unit of " + column.quantity);
  return *factor;
}

/// Columns by the names of the first line.
std::vector<Found> columns_by_names(const std::vector<std::string>& names, const std::string& unit) {
  std::vector<Found> found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::optional<CsvColumn> column = column_named(names[i]);
    if (!column) continue;
    for (const Found& other : found)
      if (other.column.quantity == column->quantity)
        throw refused("two columns hold the " + column->quantity + "; say with --columns which");
    found.push_back({*column, i, factor_for(*column, unit)});
  }
  return found;
}

bool has(const std::vector<Found>& found, std::string_view quantity) {
  return std::any_of(found.begin(), found.end(),
                     [&](const Found& f) { return f.column.quantity == quantity; });
}

void add(CsvReadings& readings, const Found& found, const std::string& field, const Line& line,
         char decimal) {
  const std::string where = "line " + std::to_string(line.number) + ", column " +
                            std::to_string(found.index + 1) + " (" + found.column.quantity + "): ";
  if (found.column.quantity == "axis") {
    if (field != "X" && field != "Y" && field != "Z")
      throw refused(where + quoted(field) + " is no axis; X, Y or Z are");
    return readings.axis.push_back(field[0]);
  }
  const std::optional<double> value = number_from(field, decimal);
  if (!value) {
    const bool comma = decimal == '.' && number_from(field, ',');
    throw refused(where + quoted(field) + " is no number" +
                  (comma ? "; for decimal commas give --decimal comma" : ""));
  }
  std::vector<double>& into = found.column.quantity == "time"       ? readings.time
                              : found.column.quantity == "position" ? readings.position
                                                                    : readings.deviation;
  into.push_back(*value * found.factor);
}

char separator_of(const CsvOptions& options, const Line& first) {
  if (options.separator != '\0') return options.separator;
  for (const char c : {'\t', ';'})
    if (first.text.find(c) != std::string_view::npos) return c;
  return ',';
}

/// The columns, and whether the first line holds names.
std::pair<std::vector<Found>, bool> find_columns(const CsvOptions& options,
                                                 const std::vector<std::string>& first) {
  if (options.columns.empty()) {
    std::vector<Found> found = columns_by_names(first, options.unit);
    if (!has(found, "deviation"))
      throw refused("no column is named deviation_UNIT, UNIT being " + std::string(kLengthUnits) +
                    "; say with --columns which column is which, e.g. time_s=1,deviation_um=2");
    return {std::move(found), true};
  }
  std::vector<Found> found;
  bool names = false;
  for (const CsvColumn& column : options.columns) {
    const std::optional<std::size_t> number = as_number(column.column);
    const std::size_t index = number ? *number - 1 : index_of(column.column, first);
    found.push_back({column, index, factor_for(column, options.unit)});
    const bool is_value =
        column.quantity == "axis" || (index < first.size() && number_from(first[index], options.decimal));
    names = names || !number || !is_value;
  }
  if (!has(found, "deviation")) throw refused("--columns does not say which column holds the deviation");
  return {std::move(found), names};
}

}  // namespace

std::vector<CsvColumn> csv_columns_from(const std::string& text) {
  std::vector<CsvColumn> columns;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t equal = part.find('=');
    const std::string name(trimmed(part.substr(0, equal)));
    std::optional<CsvColumn> column = column_named(name);
    if (!column || equal == std::string::npos)
      throw refused("--columns: " + quoted(part) +
                    " is not QUANTITY_UNIT=COLUMN; e.g. time_s=1,position_mm=2,deviation_um=3,axis=4");
    column->column = std::string(trimmed(part.substr(equal + 1)));
    if (column->column.empty()) throw refused("--columns: " + quoted(part) + " names no column");
    for (const CsvColumn& other : columns)
      if (other.quantity == column->quantity)
        throw refused("--columns: the " + other.quantity + " stands twice");
    columns.push_back(*column);
  }
  return columns;
}

CsvReadings read_csv(std::string_view bytes, const CsvOptions& options) {
  const std::vector<Line> lines = lines_of(checked_text(bytes), options.skip);
  if (lines.empty()) throw refused("holds no readings");
  const char separator = separator_of(options, lines.front());
  if (separator == options.decimal)
    throw refused("the comma cannot separate columns and decimals; give --separator");
  const auto [found, names] = find_columns(options, fields_of(lines.front(), separator));
  std::size_t needed = 0;
  for (const Found& f : found) needed = std::max(needed, f.index + 1);
  CsvReadings readings;
  for (std::size_t i = names ? 1 : 0; i < lines.size(); ++i) {
    const std::vector<std::string> fields = fields_of(lines[i], separator);
    if (fields.size() < needed)
      throw refused("line " + std::to_string(lines[i].number) + ": has " + std::to_string(fields.size()) +
                    " columns, " + std::to_string(needed) +
                    " are needed: is the file cut short, or separated otherwise?");
    for (const Found& f : found) add(readings, f, fields[f.index], lines[i], options.decimal);
  }
  if (readings.deviation.empty()) throw refused("holds names of columns, but no readings");
  return readings;
}

}  // namespace ballbar

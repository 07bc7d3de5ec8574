#include "rules/names.hpp"

#include <algorithm>
#include <cctype>

#include "pipeline/catalogue.hpp"

namespace ballbar {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

bool is_word_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

// The length of a long bracket's opening "[[" or "[==[" at `at`, or 0.
std::size_t long_bracket(std::string_view source, std::size_t at) {
  if (at >= source.size() || source[at] != '[') return 0;
  std::size_t end = at + 1;
  while (end < source.size() && source[end] == '=') ++end;
  return end < source.size() && source[end] == '[' ? end + 1 - at : 0;
}

// Where the comment that begins at `at` ("--") ends.
std::size_t end_of_comment(std::string_view source, std::size_t at) {
  const std::size_t opening = long_bracket(source, at + 2);
  if (opening == 0) return std::min(source.find('\n', at), source.size());
  const std::string closing = "]" + std::string(opening - 2, '=') + "]";
  const std::size_t end = source.find(closing, at + 2 + opening);
  return end == std::string_view::npos ? source.size() : end + closing.size();
}

bool is_quantity_of_every_run(std::string_view name) {
  return std::any_of(catalogue().begin(), catalogue().end(),
                     [&](const Quantity& q) { return q.kind == "run" && q.name == name; });
}

// Of the subjects that are no runs, and of both directions of a circle.
const std::vector<std::string_view>& quantities_of_its_own(std::string_view kind) {
  using Names = std::vector<std::string_view>;
  static const Names none;
  static const Names test{"circular_error_bidirectional_um", "mean_bidirectional_radial_error_um",
                          "positional_tolerance_um", "hysteresis_um", "hysteresis_deg"};
  static const Names silence{"hours_since_last"};
  static const Names loss{"runs", "runs_failed", "failed_percent", "lost_messages", "receiver_restarts"};
  static const Names gap{"noise_floor_um", "rms_before_um", "remainder_rms_um", "joint",
                         "level",          "share",         "evidence",         "explained_percent"};
  if (kind == "test") return test;
  if (kind == "silence") return silence;
  if (kind == "loss") return loss;
  return kind == "gap" ? gap : none;
}

}  // namespace

const std::vector<std::string_view>& label_names() {
  static const std::vector<std::string_view> names{
      "robot",        "test",    "kind",   "series",         "axis",      "status",
      "angle_source", "source",  "plane",  "predicted_from", "direction", "repetition",
      "started_us",   "verdict", "effect", "effect_kind"};
  return names;
}

bool is_label(std::string_view name) {
  return std::find(label_names().begin(), label_names().end(), name) != label_names().end();
}

const std::vector<std::string>& subjects() {
  static const std::vector<std::string> all{"circle", "line", "test", "residual", "silence", "loss", "gap"};
  return all;
}

std::vector<std::string> own_quantities(const std::string& kind) {
  const std::vector<std::string_view>& own = quantities_of_its_own(kind);
  return {own.begin(), own.end()};
}

bool is_quantity_of(std::string_view name, std::string_view kind) {
  if (kind == "circle" || kind == "line") return is_quantity(name, kind);
  if (kind == "residual")
    return name.starts_with("gap_") ? is_quantity(name, "circle") || is_quantity(name, "line")
                                    : is_quantity_of_every_run(name);
  if (kind == "test" && (is_signature_name(name) || is_quantity_of_every_run(name))) return true;
  const std::vector<std::string_view>& own = quantities_of_its_own(kind);
  return std::find(own.begin(), own.end(), name) != own.end();
}

std::string label_text(const Record& record, std::string_view name) {
  if (name == "robot") return record.robot;
  if (name == "test") return record.test;
  if (name == "kind") return record.kind;
  if (name == "series") return record.series;
  if (name == "axis") return record.axis;
  if (name == "status") return record.status;
  if (name == "angle_source") return record.angle_source;
  if (name == "source") return record.source;
  if (name == "plane") return record.plane;
  if (name == "predicted_from") return record.predicted_from;
  if (name == "direction") return (record.direction > 0 ? "+" : "") + std::to_string(record.direction);
  if (name == "repetition") return std::to_string(record.repetition);
  if (name == "started_us") return std::to_string(record.started_us);
  const auto word = record.words.find(std::string(name));
  return word != record.words.end() ? word->second : "";
}

std::string nearest(std::string_view name, const std::vector<std::string_view>& known, std::size_t most) {
  std::string_view best;
  std::size_t best_distance = most + 1;
  for (const std::string_view candidate : known) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return std::string(best);
}

std::string did_you_mean(const std::string& word) {
  return word.empty() ? "" : "; did you mean '" + word + "'?";
}

std::string suggestion(std::string_view name, std::string_view kind,
                       const std::vector<std::string_view>& more) {
  std::vector<std::string_view> known = more;
  known.insert(known.end(), label_names().begin(), label_names().end());
  for (const Quantity& quantity : catalogue())
    if (is_quantity_of(quantity.name, kind)) known.push_back(quantity.name);
  const std::vector<std::string_view>& own = quantities_of_its_own(kind);
  known.insert(known.end(), own.begin(), own.end());
  return did_you_mean(nearest(name, known, std::max<std::size_t>(2, name.size() / 3)));
}

std::vector<int> lines_with(std::string_view source, std::string_view word) {
  std::vector<int> lines;
  int line = 1;
  char quote = 0;  // the one that an open string began with
  for (std::size_t at = 0; at < source.size();) {
    const char c = source[at];
    std::size_t next = at + 1;
    if (is_word_character(c)) {
      while (next < source.size() && is_word_character(source[next])) ++next;
      if (source.substr(at, next - at) == word) lines.push_back(line);
    } else if (quote != 0 && c == '\\' && next < source.size()) {
      ++next;
    } else if (quote != 0 && (c == quote || c == '\n')) {
      quote = 0;
    } else if (quote == 0 && (c == '"' || c == '\'')) {
      quote = c;
    } else if (quote == 0 && source.substr(at, 2) == "--") {
      next = end_of_comment(source, at);
    }
    line += static_cast<int>(std::count(source.begin() + static_cast<std::ptrdiff_t>(at),
                                        source.begin() + static_cast<std::ptrdiff_t>(next), '\n'));
    at = next;
  }
  return lines;
}

int line_of(std::string_view source, std::string_view word) {
  const std::vector<int> lines = lines_with(source, word);
  return lines.empty() ? 0 : lines.front();
}

int line_of_return(std::string_view source) {
  constexpr std::string_view kReturn = "return";
  for (const int line : lines_with(source, kReturn)) {
    std::size_t begin = 0;
    for (int i = 1; i < line; ++i) begin = source.find('\n', begin) + 1;
    if (source.substr(begin, kReturn.size()) == kReturn) return line;
  }
  return 0;
}

}  // namespace ballbar

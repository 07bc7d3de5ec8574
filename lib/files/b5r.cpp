#include "files/b5r.hpp"

#include <algorithm>
#include <pugixml.hpp>

#include "core/error.hpp"
#include "files/numbers.hpp"
#include "files/text.hpp"

namespace ballbar {
namespace {

constexpr std::size_t kMaxRuns = 100;
constexpr std::size_t kMaxText = 200;  // of a label

/// The name without namespace.
std::string_view local(std::string_view name) {
  const std::size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

void keep_first(std::string& label, std::string_view text) {
  if (label.empty()) label = std::string(trimmed(text).substr(0, kMaxText));
}

int direction_from(std::string_view text) {
  const std::string_view word = trimmed(text);
  if (word == "CCW") return 1;
  if (word == "CW") return -1;
  throw refused("RUN_DIRECTION is '" + std::string(word.substr(0, 20)) + "', neither CW nor CCW");
}

std::vector<double> readings_in(const pugi::xml_node& element) {
  std::string text;  // a comment may stand between two pieces of text
  for (const pugi::xml_node& child : element.children()) {
    if (child.type() == pugi::node_element)
      throw refused("READINGS holds the element '" + std::string(child.name()) + "', not only numbers");
    text += child.value();
    text += ' ';
  }
  std::vector<double> readings;
  constexpr std::string_view kBlanks = " \t\r\n";
  std::string_view rest = text;
  for (;;) {
    const std::size_t begin = rest.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) break;
    const std::size_t end = std::min(rest.find_first_of(kBlanks, begin), rest.size());
    const std::string_view word = rest.substr(begin, end - begin);
    const std::optional<double> value = number_from(word);
    if (!value)
      throw refused("reading " + std::to_string(readings.size() + 1) + " of READINGS is '" +
                    std::string(word.substr(0, 20)) + "', no number");
    if (readings.size() == kMaxReadings)
      throw refused("READINGS holds more than " + std::to_string(kMaxReadings) + " numbers");
    readings.push_back(*value);
    rest.remove_prefix(end);
  }
  if (readings.size() < 2) throw refused("READINGS holds no readings");
  return readings;
}

/// Element by element, in sequence; without recursion, for files may be nested as deep as they like.
class Walker : public pugi::xml_tree_walker {
 public:
  B5rFile file;

  bool for_each(pugi::xml_node& node) override {
    if (node.type() != pugi::node_element) return true;
    const std::string_view name = local(node.name());
    label(name, node);
    if (name == "RUN_DIRECTION") direction_ = direction_from(node.text().get());
    if (name != "READINGS") return true;
    if (direction_ == 0) throw refused("READINGS without a RUN_DIRECTION before it");
    if (file.runs.size() == kMaxRuns) throw refused("more than " + std::to_string(kMaxRuns) + " runs");
    file.runs.push_back({direction_, readings_in(node)});
    direction_ = 0;
    return true;
  }

 private:
  void label(std::string_view name, const pugi::xml_node& node) {
    if (name == "PLANE") keep_first(file.plane, node.attribute("TEST_PLANE").value());
    if (name == "TEST_SPEC") keep_first(file.test, node.attribute("NAME").value());
    if (name == "MACHINE_TESTED") keep_first(file.machine, node.attribute("NAME").value());
    text("DATE_STARTED", file.started, name, node);
    text("OPERATOR", file.person, name, node);
    text("SERIAL_NUMBER", file.serial, name, node);
    text("LAST_CALIBRATED", file.calibrated, name, node);
  }
  /// Whether these are elements or attributes of one, no public reader says: both are taken.
  static void text(const char* wanted, std::string& into, std::string_view name, const pugi::xml_node& node) {
    if (name == wanted) keep_first(into, node.text().get());
    keep_first(into, node.attribute(wanted).value());
  }

  int direction_ = 0;
};

}  // namespace

B5rFile read_b5r(std::string_view bytes) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(bytes.data(), bytes.size());
  if (!parsed) {
    const auto end = bytes.begin() + std::clamp<std::ptrdiff_t>(parsed.offset, 0, std::ssize(bytes));
    const auto line = 1 + std::count(bytes.begin(), end, '\n');
    throw refused("line " + std::to_string(line) + ": is no whole XML (" + parsed.description() +
                  "): is the file cut short, or of another kind?");
  }
  Walker walker;
  document.traverse(walker);
  if (walker.file.runs.empty())
    throw refused("is XML, but holds no READINGS: give the result of a ballbar test (.b5r)");
  return std::move(walker.file);
}

}  // namespace ballbar

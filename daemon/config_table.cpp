#include "daemon/config_table.hpp"

#include <cmath>
#include <cstdint>
#include <optional>
#include <sstream>

#include "core/error.hpp"

namespace ballbar {
namespace {

std::string plain_number(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

}  // namespace

void TomlTable::fail(const toml::node* node, const std::string& what) const {
  fail_at((node ? *node : static_cast<const toml::node&>(table_)).source().begin, what);
}

void TomlTable::fail_at(const toml::source_position& at, const std::string& what) const {
  throw Error(Cause::kInput,
              path_ + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " + what);
}

const toml::node* TomlTable::find(const char* key) {
  known_.insert(key);
  return table_.get(key);
}

void TomlTable::require(const char* key) {
  if (!find(key)) fail(nullptr, name_ + " needs '" + key + "'");
}

double TomlTable::number(const char* key, double fallback, double least, double most) {
  const toml::node* node = find(key);
  return node ? number(*node, key, least, most) : fallback;
}

double TomlTable::number(const toml::node& node, const std::string& key, double least, double most) const {
  const std::optional<double> value = node.value<double>();
  if (!value || node.is_boolean() || node.is_string()) fail(&node, "'" + key + "' must be a number");
  if (!std::isfinite(*value) || *value < least || *value > most)
    fail(&node, "'" + key + "' = " + plain_number(*value) + " is outside " + plain_number(least) + " .. " +
                    plain_number(most));
  return *value;
}

double TomlTable::required_number(const char* key, double least, double most) {
  require(key);
  return number(key, 0.0, least, most);
}

int TomlTable::whole(const char* key, int fallback, int least, int most) {
  const toml::node* node = find(key);
  if (!node) return fallback;
  const std::optional<std::int64_t> value = node->is_integer() ? node->value<std::int64_t>() : std::nullopt;
  if (!value) fail(node, "'" + std::string(key) + "' must be a whole number");
  if (*value < least || *value > most)
    fail(node, "'" + std::string(key) + "' = " + std::to_string(*value) + " is outside " +
                   std::to_string(least) + " .. " + std::to_string(most));
  return static_cast<int>(*value);
}

bool TomlTable::flag(const char* key, bool fallback) {
  const toml::node* node = find(key);
  if (!node) return fallback;
  if (!node->is_boolean()) fail(node, "'" + std::string(key) + "' is true or false");
  return *node->value<bool>();
}

std::string TomlTable::text(const char* key, const std::string& fallback) {
  const toml::node* node = find(key);
  if (!node) return fallback;
  const std::optional<std::string> value = node->value<std::string>();
  if (!value || !node->is_string()) fail(node, "'" + std::string(key) + "' must be text in quotes");
  if (value->empty()) fail(node, "'" + std::string(key) + "' is empty");
  return *value;
}

std::string TomlTable::required_text(const char* key) {
  require(key);
  return text(key, "");
}

std::vector<double> TomlTable::numbers(const char* key, double least, double most) {
  const toml::node* node = find(key);
  if (!node) return {};
  const toml::array* array = node->as_array();
  if (!array) fail(node, "'" + std::string(key) + "' must be a list of numbers");
  std::vector<double> values;
  for (const toml::node& entry : *array) values.push_back(number(entry, key, least, most));
  return values;
}

Vec3 TomlTable::triple(const char* key, const Vec3& fallback, double limit) {
  const toml::node* node = find(key);
  if (!node) return fallback;
  const std::vector<double> values = numbers(key, -limit, limit);
  if (values.size() != 3)
    fail(node, "'" + std::string(key) + "' must hold 3 numbers, not " + std::to_string(values.size()));
  return {values[0], values[1], values[2]};
}

Vec3 TomlTable::required_triple(const char* key, double limit) {
  require(key);
  return triple(key, {}, limit);
}

void TomlTable::each(const char* key, const std::string& name, const std::function<void(TomlTable&)>& read) {
  const toml::node* node = find(key);
  if (!node) return;
  const toml::array* array = node->as_array();
  if (!array || !array->is_array_of_tables()) fail(node, "write [[" + name + "]] for each one");
  for (const toml::node& entry : *array) {
    TomlTable table(*entry.as_table(), "[[" + name + "]]", path_);
    read(table);
    table.done();
  }
}

void TomlTable::section(const char* key, const std::function<void(TomlTable&)>& read) {
  const toml::node* node = find(key);
  if (!node) return;
  if (!node->is_table()) fail(node, "write [" + std::string(key) + "] as a table");
  TomlTable table(*node->as_table(), "[" + std::string(key) + "]", path_);
  read(table);
  table.done();
}

void TomlTable::done() const {
  for (const auto& [key, node] : table_) {
    if (known_.contains(std::string(key.str()))) continue;
    std::string known;
    for (const std::string& k : known_) known += (known.empty() ? "" : ", ") + k;
    fail_at(key.source().begin,
            "unknown key '" + std::string(key.str()) + "' in " + name_ + "; known are: " + known);
  }
}

}  // namespace ballbar

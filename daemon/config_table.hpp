#pragma once
/// One table of a TOML file, read key by key: what is wrong is an Error(kInput) with file, line and column.

#include <toml++/toml.h>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "core/spec.hpp"

namespace ballbar {

/// Of each key that is asked for it takes note; done() complains of those that nobody asked for.
class TomlTable {
 public:
  /// @param table  must outlive this
  /// @param name   as people write it: "[[robot]]"
  /// @param path   of the file
  TomlTable(const toml::table& table, std::string name, std::string path)
      : table_(table), name_(std::move(name)), path_(std::move(path)) {}

  /// @param node  where it is wrong; null: where the table begins
  [[noreturn]] void fail(const toml::node* node, const std::string& what) const;

  /// Null where the key is not there.
  const toml::node* find(const char* key);

  // The value of a key, in [least, most]; `fallback` where it is not there, an error where it is required.
  double number(const char* key, double fallback, double least, double most);
  double number(const toml::node& node, const std::string& key, double least, double most) const;
  double required_number(const char* key, double least, double most);
  int whole(const char* key, int fallback, int least, int most);
  bool flag(const char* key, bool fallback);
  std::string text(const char* key, const std::string& fallback);  ///< never empty
  std::string required_text(const char* key);
  std::vector<double> numbers(const char* key, double least, double most);  ///< empty where it is not there
  Vec3 triple(const char* key, const Vec3& fallback, double limit);         ///< in [-limit, limit]
  Vec3 required_triple(const char* key, double limit);

  /// Tables of an array of tables, e.g. [[robot]].
  void each(const char* key, const std::string& name, const std::function<void(TomlTable&)>& read);
  void section(const char* key, const std::function<void(TomlTable&)>& read);

  /// To be called when all keys have been asked for.
  void done() const;

  const toml::table& raw() const { return table_; }
  const std::string& path() const { return path_; }

 private:
  [[noreturn]] void fail_at(const toml::source_position& at, const std::string& what) const;
  void require(const char* key);

  const toml::table& table_;
  std::string name_;
  std::string path_;
  std::set<std::string> known_;
};

}  // namespace ballbar

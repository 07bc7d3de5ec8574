#pragma once
/// Reads a table that a script returned. All calls in protected mode, the table at stack index 1.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "rules/rule.hpp"

struct lua_State;

namespace ballbar {

class LuaTable {
 public:
  /// `lua` and `source` stay the caller's.
  /// @throws ScriptError where the script did not return a table
  LuaTable(lua_State* lua, const RuleSource& source);

  /// Absent: nullopt. @throws ScriptError where the value is of another type
  std::optional<std::string> word(const char* key) const;
  std::optional<int> whole_number(const char* key, int least, int most) const;
  std::vector<std::string> list_of_words(const char* key) const;

  bool has_function(const char* key) const;

  /// Calls visit(key) with each key of the table at `index` and its value on top of the stack (leave it
  /// there).
  /// @throws ScriptError where a key is not a word
  void each(int index, const char* what, const std::function<void(const std::string&)>& visit) const;

  /// The value on top of the stack as number, word or true/false; nullopt where it is something else or not
  /// finite.
  std::optional<std::variant<double, std::string, bool>> constant() const;

  /// ScriptError at the first line that holds `word`; at the file's own return where it is "return".
  [[noreturn]] void fail(const std::string& word, const std::string& message) const;

  lua_State* lua() const { return lua_; }

 private:
  lua_State* lua_;
  const RuleSource& source_;
};

}  // namespace ballbar

#pragma once
/// Runs text that other people wrote, in Lua 5.4, so that it can neither reach the machine nor hold it up.

#include <cstddef>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

struct lua_State;

namespace ballbar {

/// Budgets of one run of a script (loading it and calling it together). A rule needs some ten thousand
/// instructions and 200 KiB.
inline constexpr std::size_t kLuaMemory = std::size_t{4} << 20;  ///< [bytes] in all
inline constexpr std::size_t kLuaMaxBlock = std::size_t{64}
                                            << 10;  ///< [bytes] in one piece: tables of about 4000 entries
inline constexpr std::size_t kLuaMaxString = 4096;  ///< [bytes]
inline constexpr int kLuaInstructions = 1'000'000;  ///< of the virtual machine; some 10 ms
inline constexpr int kLuaHookEvery = 1000;          ///< instructions between two looks at the budget

/// A script is wrong or over budget. what() is one line without file or line number.
class ScriptError : public std::runtime_error {
 public:
  ScriptError(int line, const std::string& message) : std::runtime_error(message), line_(line) {}
  int line() const { return line_; }  ///< from 1; 0 where no line can be named

 private:
  int line_;
};

/// A script that is compiled once and run many times, each time from its text: nothing that one run leaves is
/// seen by the next. Not for two threads at once.
///
/// The script sees only: assert error ipairs pairs next select tonumber tostring type; string.{format len
/// lower upper sub byte contains}; table.{insert remove concat sort unpack}; math without random. Patterns,
/// metatables, pcall, load and everything that reaches out are absent, because each of them can outlast the
/// budgets or leave the sandbox. Each run has tables and functions of its own; what it made is garbage after
/// it, no finalizer can exist, and a run that ended in an error takes the whole state with it.
class Script {
 public:
  explicit Script(std::string source);
  ~Script();
  Script(const Script&) = delete;
  Script& operator=(const Script&) = delete;

  /// Runs the text, and calls `use` with the value that it returned at stack index 1. `use` runs inside a
  /// protected call: it may use the Lua API freely, and may throw std::exception.
  /// @throws ScriptError for syntax errors, run-time errors, blocked functions and exceeded budgets
  void run(const std::function<void(lua_State*)>& use);

 private:
  struct State;
  std::string source_;
  std::unique_ptr<State> state_;
};

/// One run of a script that is not run again.
void run_sandboxed(const std::string& source, const std::function<void(lua_State*)>& use);

}  // namespace ballbar

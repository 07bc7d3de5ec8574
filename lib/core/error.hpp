#pragma once
/// Errors of the world outside: one line that says what, where, and what to do.

#include <stdexcept>
#include <string>

namespace ballbar {

enum class Cause {
  kInput,  ///< bad use, bad file, bad configuration: exit code 2
  kWorld,  ///< no database, no bus, no disk: exit code 3
};

/// Thrown where the world fails; caught where an operation ends (main, one run, one reload).
/// A recording that holds no answer is not an error but a RunStatus.
class Error : public std::runtime_error {
 public:
  Error(Cause cause, const std::string& what) : std::runtime_error(what), cause_(cause) {}
  Cause cause() const { return cause_; }

 private:
  Cause cause_;
};

}  // namespace ballbar

#pragma once
/// One child process whose output is collected without waiting for it.

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace ballbar {

class ChildOutput {
 public:
  struct Ended {
    int code = -1;  ///< exit code; 128 + signal where one ended it
    std::string out, err;
  };

  ChildOutput() = default;
  ~ChildOutput();  ///< kills the child
  ChildOutput(const ChildOutput&) = delete;
  ChildOutput& operator=(const ChildOutput&) = delete;

  /// @param command  program and arguments
  /// @throws Error(kWorld) where no process can be made
  void start(std::vector<std::string> command);
  bool running() const { return pid_ > 0; }
  pid_t pid() const { return pid_; }

  /// Takes what has been written so far, never blocks. Something when the child has ended.
  std::optional<Ended> poll();

  void kill();

 private:
  void take(int& fd, std::string& text);

  pid_t pid_ = -1;
  int out_ = -1, err_ = -1;
  Ended heard_;
};

}  // namespace ballbar

#pragma once
/// Real processes for tests: run to the end, or in the background until stopped.

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "support/temp_dir.hpp"

extern char** environ;

namespace ballbar::test {

inline std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline void write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
}

struct Outcome {
  int code = -1;  ///< exit code; 128 + signal where one ended it
  std::string out, err;
};

/// A process in the background; killed when the test ends.
class Background {
 public:
  /// @param environment  "NAME=value", beside the test's own
  Background(std::vector<std::string> command, const std::string& log_path,
             std::vector<std::string> environment = {})
      : log_path_(log_path) {
    std::vector<char*> arguments;
    for (std::string& word : command) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    std::vector<char*> variables;
    for (std::string& word : environment) variables.push_back(word.data());
    for (char** v = environ; *v; ++v) variables.push_back(*v);
    variables.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, (log_path + ".out").c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                     0644);
    posix_spawn_file_actions_addopen(&actions, 2, (log_path + ".err").c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                     0644);
    posix_spawn_file_actions_addclosefrom_np(&actions,
                                             3);  // a socket of ours that nobody there reads fills up
    const int error =
        posix_spawnp(&pid_, arguments[0], &actions, nullptr, arguments.data(), variables.data());
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::runtime_error("cannot start " + command[0]);
  }
  ~Background() {
    if (pid_ > 0) kill(pid_, SIGKILL);
    wait();
  }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  /// Nothing where the process has ended: kill(-1) would reach every process of this machine.
  void signal(int number) const {
    if (pid_ > 0) kill(pid_, number);
  }
  pid_t pid() const { return pid_; }
  bool alive() {
    if (pid_ <= 0) return false;
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) != pid_) return true;
    finish(status);
    return false;
  }
  int wait() {
    if (pid_ > 0) {
      int status = 0;
      while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
      }
      finish(status);
    }
    return code_;
  }
  std::string out() const { return read_file(log_path_ + ".out"); }
  std::string err() const { return read_file(log_path_ + ".err"); }

 private:
  void finish(int status) {
    pid_ = -1;
    code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  pid_t pid_ = -1;
  int code_ = -1;
  std::string log_path_;
};

inline Outcome run(std::vector<std::string> command) {
  const TempDir dir;
  Background process(std::move(command), dir.path() + "/run");
  Outcome outcome;
  outcome.code = process.wait();
  outcome.out = process.out();
  outcome.err = process.err();
  return outcome;
}

inline const std::string kBallbar = BALLBAR_BUILD_DIR "/daemon/ballbar";
inline const std::string kBallbard = BALLBAR_BUILD_DIR "/daemon/ballbard";

}  // namespace ballbar::test

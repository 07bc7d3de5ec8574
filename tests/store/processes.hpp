#pragma once
/// Other processes for tests: a piece of code in a child, whose end is its answer.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <stdexcept>

namespace ballbar::test {

/// Runs `work()` in a child; its result is the exit code, 99 where it throws. Killed if it still runs at the
/// end.
class Child {
 public:
  template <class Work>
  explicit Child(Work work) {
    std::fflush(nullptr);
    pid_ = ::fork();
    if (pid_ < 0) throw std::runtime_error("cannot fork");
    if (pid_ == 0) {
      int code = 99;
      try {
        code = work();
      } catch (const std::exception& e) {
        std::fprintf(stderr, "child: %s\n", e.what());
      }
      ::_exit(code);
    }
  }
  ~Child() {
    if (pid_ > 0) kill();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Exit code, or -signal.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  int kill() {
    ::kill(pid_, SIGKILL);
    return wait();
  }

 private:
  ::pid_t pid_ = -1;
};

/// A pipe with a word for each of its two uses.
class Pipe {
 public:
  Pipe() {
    if (::pipe(ends_) != 0) throw std::runtime_error("cannot make a pipe");
  }
  ~Pipe() {
    close_read();
    close_write();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  void put(long long value) {
    if (::write(ends_[1], &value, sizeof value) != static_cast<ssize_t>(sizeof value))
      throw std::runtime_error("pipe");
  }
  /// False at the end, when nobody can put any more.
  bool take(long long& value) {
    return ::read(ends_[0], &value, sizeof value) == static_cast<ssize_t>(sizeof value);
  }
  void close_read() { close(0); }
  void close_write() { close(1); }

 private:
  void close(int end) {
    if (ends_[end] >= 0) ::close(ends_[end]);
    ends_[end] = -1;
  }
  int ends_[2] = {-1, -1};
};

}  // namespace ballbar::test

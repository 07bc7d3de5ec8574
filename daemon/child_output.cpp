#include "daemon/child_output.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include "bus/spawn.hpp"
#include "core/error.hpp"

namespace ballbar {
namespace {

constexpr std::size_t kMostBytes = std::size_t{8} << 20;  // of either output; a child that says more is ended

}  // namespace

ChildOutput::~ChildOutput() { kill(); }

void ChildOutput::start(std::vector<std::string> command) {
  kill();
  std::array<int, 2> out{-1, -1}, err{-1, -1};
  if (pipe2(out.data(), O_CLOEXEC) != 0 || pipe2(err.data(), O_CLOEXEC) != 0) {
    for (const int fd : {out[0], out[1]})
      if (fd >= 0) close(fd);
    throw Error(Cause::kWorld, std::string("no pipe: ") + std::strerror(errno));
  }
  const std::string program = command.at(0);
  const int error = spawn(
      {.command = std::move(command),
       .files = {{SpawnFile::kNothing, STDIN_FILENO}, {out[1], STDOUT_FILENO}, {err[1], STDERR_FILENO}}},
      pid_);
  close(out[1]);
  close(err[1]);
  out_ = out[0];
  err_ = err[0];
  heard_ = {};
  if (error != 0) {
    pid_ = -1;
    kill();
    throw Error(Cause::kWorld, program + " cannot be started: " + std::strerror(error));
  }
  for (const int fd : {out_, err_}) fcntl(fd, F_SETFL, O_NONBLOCK);
}

void ChildOutput::take(int& fd, std::string& text) {
  std::array<char, 65536> buffer{};
  while (fd >= 0) {
    const ssize_t size = read(fd, buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno == EAGAIN) return;
    if (size <= 0) {
      close(fd);
      fd = -1;
      return;
    }
    text.append(buffer.data(), static_cast<std::size_t>(size));
    if (text.size() > kMostBytes) {
      ::kill(pid_, SIGKILL);
      return;
    }
  }
}

std::optional<ChildOutput::Ended> ChildOutput::poll() {
  if (pid_ <= 0) return std::nullopt;
  int status = 0;
  const bool ended = waitpid(pid_, &status, WNOHANG) == pid_;
  take(out_, heard_.out);  // behind waitpid: what it wrote last is there now
  take(err_, heard_.err);
  if (!ended) return std::nullopt;
  pid_ = -1;
  heard_.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  Ended result = std::move(heard_);
  kill();
  return result;
}

void ChildOutput::kill() {
  if (pid_ > 0) {
    ::kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  pid_ = -1;
  for (int* fd : {&out_, &err_}) {
    if (*fd >= 0) close(*fd);
    *fd = -1;
  }
}

}  // namespace ballbar

/// render(): gnuplot as a child without a shell. The script goes in and the picture comes out through files
/// of our own, so that neither a path nor a name is ever read as a command.

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "report/plot.hpp"

extern char** environ;

namespace ballbar {
namespace {

class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

/// A picture under a name of its own until it is complete; removed if it never is.
class Draft {
 public:
  explicit Draft(const std::string& target) : target_(target), name_(target + ".XXXXXX") {
    descriptor_ = ::mkostemp(name_.data(), O_CLOEXEC);
    if (descriptor_ < 0) fail("cannot be written");
    const mode_t mask = ::umask(0);
    ::umask(mask);
    ::fchmod(descriptor_, 0666 & ~mask);  // as any other file that the user makes
  }
  ~Draft() {
    ::close(descriptor_);
    if (!kept_) ::unlink(name_.c_str());
  }
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;
  int get() const { return descriptor_; }

  void keep() {
    if (::rename(name_.c_str(), target_.c_str()) != 0) fail("cannot be written");
    kept_ = true;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(Cause::kWorld, target_ + ": " + what + ": " + std::strerror(errno));
  }

  std::string target_, name_;
  int descriptor_ = -1;
  bool kept_ = false;
};

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() > end.size() && text.substr(text.size() - end.size()) == end;
}

std::string terminal(const PlotScript& script, const std::string& path) {
  const std::string size = " size " + std::to_string(script.width) + "," + std::to_string(script.height);
  if (ends_with(path, ".svg"))
    return "set terminal svg dynamic noenhanced font 'sans-serif,17' background '#ffffff'" + size + "\n";
  if (ends_with(path, ".png"))
    return "set terminal pngcairo noenhanced font 'sans-serif,17' fontscale 0.75 background '#ffffff'" +
           size + "\n";
  throw Error(Cause::kInput, path + ": a picture's name ends in .svg or .png");
}

void write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      throw Error(Cause::kWorld, std::string("gnuplot: no memory for its script: ") + std::strerror(errno));
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

/// The last line that says something: gnuplot repeats the offending line first and gives the reason at the
/// end.
std::string last_line(int descriptor) {
  std::array<char, 4096> buffer{};
  const ssize_t size = ::pread(descriptor, buffer.data(), buffer.size(), 0);
  std::string_view text(buffer.data(), size < 0 ? 0 : static_cast<std::size_t>(size));
  const std::size_t end = text.find_last_not_of(" \t\r\n");
  if (end == std::string_view::npos) return "it gives no reason";
  text = text.substr(0, end + 1);
  const std::size_t begin = text.find_last_of('\n');
  text = begin == std::string_view::npos ? text : text.substr(begin + 1);
  return std::string(text.substr(text.find_first_not_of(" \t")));
}

/// Runs gnuplot on the three descriptors and waits for it; returns its wait status.
int run_gnuplot(int in, int out, int err) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, err, STDERR_FILENO);
  std::string name = "gnuplot";
  std::string defaults = "-d";  // not the user's ~/.gnuplot
  std::array<char*, 3> arguments{name.data(), defaults.data(), nullptr};
  pid_t child = 0;
  const int failure = ::posix_spawnp(&child, name.c_str(), &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (failure == ENOENT) throw Error(Cause::kWorld, "gnuplot is missing: install gnuplot-nox");
  if (failure != 0)
    throw Error(Cause::kWorld, std::string("gnuplot does not start: ") + std::strerror(failure));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) throw Error(Cause::kWorld, std::string("gnuplot is lost: ") + std::strerror(errno));
  }
  return status;
}

}  // namespace

namespace {

/// @param what  what is drawn, for the error
void draw(const std::string& text, int out, const std::string& what) {
  const File in(::memfd_create("gnuplot-script", MFD_CLOEXEC));
  const File err(::memfd_create("gnuplot-messages", MFD_CLOEXEC));
  if (in.get() < 0 || err.get() < 0)
    throw Error(Cause::kWorld, std::string("gnuplot: no memory for its script: ") + std::strerror(errno));
  write_all(in.get(), text);
  ::lseek(in.get(), 0, SEEK_SET);

  const int status = run_gnuplot(in.get(), out, err.get());
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw Error(Cause::kWorld, "gnuplot cannot draw " + what + ": " + last_line(err.get()));
  if (::lseek(out, 0, SEEK_END) <= 0)
    throw Error(Cause::kWorld,
                "gnuplot cannot draw " + what + ": it wrote nothing (" + last_line(err.get()) + ")");
}

}  // namespace

void render(const PlotScript& script, const std::string& path) {
  const std::string text = terminal(script, path) + script.text;
  Draft draft(path);
  draw(text, draft.get(), path);
  draft.keep();
}

std::string svg_of(const PlotScript& script) {
  const std::string text = terminal(script, "picture.svg") + script.text;
  const File out(::memfd_create("gnuplot-picture", MFD_CLOEXEC));
  if (out.get() < 0)
    throw Error(Cause::kWorld, std::string("gnuplot: no memory for its picture: ") + std::strerror(errno));
  draw(text, out.get(), "a picture");
  std::string svg(static_cast<std::size_t>(::lseek(out.get(), 0, SEEK_END)), '\0');
  const ssize_t got = ::pread(out.get(), svg.data(), svg.size(), 0);
  if (got != static_cast<ssize_t>(svg.size()))
    throw Error(Cause::kWorld, std::string("gnuplot: its picture cannot be read: ") + std::strerror(errno));
  return svg;
}

}  // namespace ballbar

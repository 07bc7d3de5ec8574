// Preloaded into a process: its database's disk is slow, full or read-only, or the time of day is another, as
// the file that BALLBAR_FAULT names says at the moment: "slow MILLISECONDS", "full", "readonly", "clock
// SECONDS" (so much ahead), or nothing.

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

namespace {

bool of_database(int fd) {
  char link[64];
  char path[512];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t size = readlink(link, path, sizeof path - 1);
  path[size > 0 ? size : 0] = '\0';
  return std::strstr(path, ".db") != nullptr;
}

/// What the machine does: errno of a write, milliseconds of a sync, seconds that the time of day is ahead.
struct Fault {
  int write_error = 0;
  int slow_ms = 0;
  long ahead_s = 0;
};

Fault fault() {
  Fault found;
  const char* control = std::getenv("BALLBAR_FAULT");
  const int file = control ? open(control, O_RDONLY | O_CLOEXEC) : -1;
  if (file < 0) return found;
  char text[64] = "";
  if (read(file, text, sizeof text - 1) > 0) {
    if (std::strncmp(text, "full", 4) == 0) found.write_error = ENOSPC;
    if (std::strncmp(text, "readonly", 8) == 0) found.write_error = EROFS;
    if (std::strncmp(text, "slow ", 5) == 0) found.slow_ms = std::atoi(text + 5);
    if (std::strncmp(text, "clock ", 6) == 0) found.ahead_s = std::atol(text + 6);
  }
  close(file);
  return found;
}

Fault disk(int fd) { return of_database(fd) ? fault() : Fault{}; }

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

int slow_sync(int fd, const char* name) {
  usleep(static_cast<useconds_t>(disk(fd).slow_ms) * 1000);
  static const auto fsync_of_libc = next<int (*)(int)>("fsync");
  static const auto fdatasync_of_libc = next<int (*)(int)>("fdatasync");
  return std::strcmp(name, "fsync") == 0 ? fsync_of_libc(fd) : fdatasync_of_libc(fd);
}

}  // namespace

extern "C" {

int fsync(int fd) { return slow_sync(fd, "fsync"); }
int fdatasync(int fd) { return slow_sync(fd, "fdatasync"); }

ssize_t pwrite64(int fd, const void* data, size_t size, off64_t offset) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t, off64_t)>("pwrite64");
  const Fault now = disk(fd);
  if (now.write_error == 0) return real(fd, data, size, offset);
  errno = now.write_error;
  return -1;
}

ssize_t pwrite(int fd, const void* data, size_t size, off_t offset) {
  return pwrite64(fd, data, size, offset);
}

int clock_gettime(clockid_t clock, timespec* now) noexcept {
  static const auto real = next<int (*)(clockid_t, timespec*)>("clock_gettime");
  const int code = real(clock, now);
  if (code == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE))
    now->tv_sec += fault().ahead_s;
  return code;
}

int gettimeofday(timeval* __restrict now, void* __restrict zone) noexcept {
  static const auto real = next<int (*)(timeval*, void*)>("gettimeofday");
  const int code = real(now, zone);
  if (code == 0) now->tv_sec += fault().ahead_s;
  return code;
}

time_t time(time_t* out) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (out) *out = now.tv_sec;
  return now.tv_sec;
}

}  // extern "C"

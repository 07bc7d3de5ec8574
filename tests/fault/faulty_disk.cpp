// Preloaded into a process: its database's disk is slow, full or read-only, as the file that BALLBAR_FAULT
// names says at the moment: "slow MILLISECONDS", "full", "readonly", or nothing.

#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

bool of_database(int fd) {
  char link[64];
  char path[512];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t size = readlink(link, path, sizeof path - 1);
  path[size > 0 ? size : 0] = '\0';
  return std::strstr(path, ".db") != nullptr;
}

/// What the disk does: errno of a write, or milliseconds of a sync.
struct Fault {
  int write_error = 0;
  int slow_ms = 0;
};

Fault fault(int fd) {
  Fault found;
  const char* control = std::getenv("BALLBAR_FAULT");
  if (!control || !of_database(fd)) return found;
  char text[64] = "";
  const int file = open(control, O_RDONLY | O_CLOEXEC);
  if (file < 0) return found;
  if (read(file, text, sizeof text - 1) > 0) {
    if (std::strncmp(text, "full", 4) == 0) found.write_error = ENOSPC;
    if (std::strncmp(text, "readonly", 8) == 0) found.write_error = EROFS;
    if (std::strncmp(text, "slow ", 5) == 0) found.slow_ms = std::atoi(text + 5);
  }
  close(file);
  return found;
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

int slow_sync(int fd, const char* name) {
  usleep(static_cast<useconds_t>(fault(fd).slow_ms) * 1000);
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
  const Fault now = fault(fd);
  if (now.write_error == 0) return real(fd, data, size, offset);
  errno = now.write_error;
  return -1;
}

ssize_t pwrite(int fd, const void* data, size_t size, off_t offset) {
  return pwrite64(fd, data, size, offset);
}

}  // extern "C"

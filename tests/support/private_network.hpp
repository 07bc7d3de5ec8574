#pragma once
/// Multicast on a loopback of the test's own: a network namespace in which nobody else speaks, and nothing
/// gets out of.

#include <sched.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "support/process.hpp"

namespace ballbar::test {

/// Moves this process, and all that it starts from now on, into a network namespace with multicast on
/// loopback.
/// @return empty, or what failed
inline std::string enter_private_network() {
  static const std::string failure = []() -> std::string {
    const uid_t uid = getuid();
    const gid_t gid = getgid();
    if (uid == 0) {
      if (unshare(CLONE_NEWNET) != 0) return std::string("no network namespace: ") + std::strerror(errno);
    } else {
      if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0)
        return std::string("no network namespace for this user: ") + std::strerror(errno);
      write_file("/proc/self/setgroups", "deny");
      write_file("/proc/self/uid_map", "0 " + std::to_string(uid) + " 1");
      write_file("/proc/self/gid_map", "0 " + std::to_string(gid) + " 1");
    }
    const Outcome up = run({"ip", "link", "set", "lo", "up"});
    if (up.code != 0) return "loopback: " + up.err;
    const Outcome route = run({"ip", "route", "add", "239.255.76.67/32", "dev", "lo", "src", "127.0.0.1"});
    return route.code == 0 ? "" : "route: " + route.err;
  }();
  return failure;
}

}  // namespace ballbar::test

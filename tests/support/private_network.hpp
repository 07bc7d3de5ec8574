#pragma once
/// Multicast on a loopback of the test's own: a network namespace in which nobody else speaks, and nothing
/// gets out of.

#include <sched.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

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

/// [bytes of kernel memory] of datagrams that nobody has read yet, in all sockets of this network on LCM's
/// port.
inline std::int64_t unread_datagrams() {
  std::ifstream table("/proc/self/net/udp");
  std::int64_t bytes = 0;
  for (std::string line; std::getline(table, line);) {
    std::istringstream words(line);
    std::string number, local, remote, state, queues;
    words >> number >> local >> remote >> state >> queues;
    const std::size_t colon = queues.find(':');
    if (local.ends_with(":1DF3") && colon != std::string::npos)
      bytes += std::stoll(queues.substr(colon + 1), nullptr, 16);
  }
  return bytes;
}

/// Waits, for a minute at most, until no more than `most` bytes are unread: whoever sends like a real
/// instrument is not faster than this machine. @return whether that came
inline bool wait_for_readers(std::int64_t most) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (unread_datagrams() > most) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace ballbar::test

#pragma once
/// What people tell the running daemon: a UNIX socket beside it, one line of JSON asks, one answers. The
/// kernel says who asks.

#include <systemd/sd-event.h>

#include <cstdint>
#include <list>
#include <string>

#include "daemon/alarm_book.hpp"

namespace ballbar {

inline constexpr std::size_t kMaxRequest = 4096;  ///< [bytes] of a request, and of an answer
inline constexpr std::size_t kMaxClients = 8;     ///< that wait at a time; the oldest is sent away

/// A connection that asks.
struct Peer {
  std::uint32_t user = 0;  ///< id
  std::string name;        ///< of the user; "uid 1000" where it has none
};

/// Carries out a request and says what came of it: {"ok": true} or {"error": "..."}. Requests are objects:
///
///     {"verb": "acknowledge" | "shelve" | "unshelve", "alarm": ID, "comment": "...", "name": "...",
///      "until_us": microseconds since 1970, for shelve}
///
/// `name` is whom the user acts for: it is stored as "name (user)".
std::string answer(AlarmBook& alarms, const std::string& request, const Peer& peer, std::int64_t now_us);

/// The daemon's end: SOCK_SEQPACKET, so that a message is a request, whole or not at all.
class ControlSocket {
 public:
  using Answer = std::string (*)(void* self, const std::string& request, const Peer& peer);

  /// Makes the socket, mode 0660. One that a dead daemon has left behind is replaced.
  /// @throws Error(kWorld) where it cannot be made, or another daemon answers at it
  ControlSocket(sd_event* event, std::string path, Answer answer, void* self);
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

 private:
  struct Client {
    ControlSocket* socket = nullptr;
    int fd = -1;
    sd_event_source* source = nullptr;
  };
  void on_connect();
  void on_request(Client& client);
  void leave(Client& client);

  sd_event* event_;
  std::string path_;
  Answer answer_;
  void* self_;
  int fd_ = -1;
  sd_event_source* source_ = nullptr;
  std::list<Client> clients_;
};

/// The tool's end: asks, and waits at most ten seconds for the answer.
/// @throws Error(kInput) with the daemon's error; Error(kWorld) where nobody answers
void ask(const std::string& path, const std::string& request);

}  // namespace ballbar

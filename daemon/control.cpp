#include "daemon/control.hpp"

#include <pwd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/error.hpp"
#include "daemon/json_out.hpp"
#include "store/store.hpp"

namespace ballbar {
namespace {

constexpr int kWaitS = 10;
constexpr std::size_t kMaxWords = 1000;  // [bytes] of a comment
constexpr std::size_t kMaxName = 100;    // [bytes]

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    throw Error(Cause::kInput,
                path + ": longer than the " + std::to_string(sizeof address.sun_path - 1) +
                    " bytes that the name of a socket may have; choose another [control] socket");
  path.copy(address.sun_path, path.size());
  return address;
}

int new_socket(int flags) {
  const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | flags, 0);
  if (fd < 0) throw Error(Cause::kWorld, std::string("no socket: ") + std::strerror(errno));
  return fd;
}

bool connects(int fd, const sockaddr_un& address) {
  return connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

Peer peer_of(int fd) {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  Peer peer;
  if (getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) {
    peer.name = "unknown";
    return peer;
  }
  peer.user = credentials.uid;
  peer.name = "uid " + std::to_string(credentials.uid);
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> buffer{};
  if (getpwuid_r(credentials.uid, &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr)
    peer.name = found->pw_name;
  return peer;
}

std::string words_of(const Json& request, const char* key, std::size_t most) {
  const auto found = request.find(key);
  if (found == request.end()) return "";
  if (!found->is_string()) throw Error(Cause::kInput, std::string("'") + key + "' must be text");
  std::string words = found->get<std::string>();
  if (words.size() > most)
    throw Error(Cause::kInput,
                std::string("'") + key + "' is longer than " + std::to_string(most) + " bytes");
  for (char& c : words)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return words;
}

std::int64_t whole_of(const Json& request, const char* key) {
  const auto found = request.find(key);
  if (found == request.end() || !found->is_number_integer())
    throw Error(Cause::kInput, std::string("'") + key + "' must be given, as a whole number");
  return found->get<std::int64_t>();
}

void carry_out(AlarmBook& alarms, const Json& request, const Peer& peer, std::int64_t now_us) {
  if (!request.is_object()) throw Error(Cause::kInput, "a request is one JSON object");
  const std::string verb = words_of(request, "verb", kMaxName);
  const std::string comment = words_of(request, "comment", kMaxWords);
  const std::string name = words_of(request, "name", kMaxName);
  const std::string by = name.empty() ? peer.name : name + " (" + peer.name + ")";
  const std::int64_t id = whole_of(request, "alarm");
  if (verb == "acknowledge") return alarms.acknowledge(id, by, comment, now_us);
  if (verb == "shelve") return alarms.shelve(id, whole_of(request, "until_us"), by, comment, now_us);
  if (verb == "unshelve") return alarms.unshelve(id, by, comment, now_us);
  throw Error(Cause::kInput, "'verb' is \"acknowledge\", \"shelve\" or \"unshelve\", not \"" + verb + "\"");
}

std::string line_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string answer(AlarmBook& alarms, const std::string& request, const Peer& peer, std::int64_t now_us) {
  try {
    carry_out(alarms, Json::parse(request), peer, now_us);
    return line_of({{"ok", true}});
  } catch (const Json::exception&) {
    return line_of({{"error", "a request is one JSON object"}});
  } catch (const std::exception& error) {  // nothing may pass through sd-event, which is C
    return line_of({{"error", error.what()}});
  }
}

ControlSocket::ControlSocket(sd_event* event, std::string path, Answer answer, void* self)
    : event_(event), path_(std::move(path)), answer_(answer), self_(self) {
  const sockaddr_un address = address_of(path_);
  const int probe = new_socket(SOCK_NONBLOCK);
  const bool taken = connects(probe, address);
  close(probe);
  if (taken)
    throw Error(Cause::kWorld, path_ + ": another ballbard answers there; choose another [control] socket");
  struct stat there {};
  if (lstat(path_.c_str(), &there) == 0 && S_ISSOCK(there.st_mode)) unlink(path_.c_str());
  fd_ = new_socket(SOCK_NONBLOCK);
  const bool open = bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
                    chmod(path_.c_str(), 0660) == 0 && listen(fd_, kMaxClients) == 0;
  const auto on_connect = [](sd_event_source*, int, std::uint32_t, void* control) {
    static_cast<ControlSocket*>(control)->on_connect();
    return 0;
  };
  if (!open || sd_event_add_io(event_, &source_, fd_, EPOLLIN, on_connect, this) < 0) {
    const int why = errno;
    close(fd_);
    throw Error(Cause::kWorld, path_ + ": " + std::strerror(why));
  }
}

ControlSocket::~ControlSocket() {
  while (!clients_.empty()) leave(clients_.front());
  sd_event_source_disable_unref(source_);
  close(fd_);
  unlink(path_.c_str());
}

void ControlSocket::on_connect() {
  const int fd = accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (fd < 0) return;
  if (clients_.size() >= kMaxClients) leave(clients_.front());
  Client& client = clients_.emplace_back(Client{this, fd, nullptr});
  const auto on_request = [](sd_event_source*, int, std::uint32_t, void* asking) {
    auto* asks = static_cast<Client*>(asking);
    asks->socket->on_request(*asks);
    return 0;
  };
  if (sd_event_add_io(event_, &client.source, fd, EPOLLIN, on_request, &client) < 0) leave(client);
}

void ControlSocket::on_request(Client& client) {
  std::array<char, kMaxRequest> buffer{};
  const ssize_t size = recv(client.fd, buffer.data(), buffer.size(), MSG_TRUNC | MSG_DONTWAIT);
  if (size > 0) {
    const std::string said =
        static_cast<std::size_t>(size) > buffer.size()
            ? line_of({{"error", "a request has at most " + std::to_string(kMaxRequest) + " bytes"}})
            : answer_(self_, std::string(buffer.data(), static_cast<std::size_t>(size)), peer_of(client.fd));
    send(client.fd, said.data(), said.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  }
  leave(client);
}

void ControlSocket::leave(Client& client) {
  sd_event_source_disable_unref(client.source);
  close(client.fd);
  clients_.remove_if([&](const Client& other) { return &other == &client; });
}

void ask(const std::string& path, const std::string& request) {
  const sockaddr_un address = address_of(path);
  const int fd = new_socket(0);
  const timeval wait{kWaitS, 0};
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
  setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &wait, sizeof wait);
  std::array<char, kMaxRequest> buffer{};
  ssize_t size = -1;
  if (connects(fd, address) &&
      send(fd, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size()))
    size = recv(fd, buffer.data(), buffer.size(), 0);
  const int why = errno;
  close(fd);
  if (size <= 0)
    throw Error(Cause::kWorld, path + ": " + (size < 0 ? std::strerror(why) : "no answer") +
                                   "; does ballbard run, and are you in the group ballbard?");
  const Json said = Json::parse(std::string(buffer.data(), static_cast<std::size_t>(size)), nullptr, false);
  if (said.is_object() && said.contains("error") && said["error"].is_string())
    throw Error(Cause::kInput, said["error"].get<std::string>());
}

}  // namespace ballbar

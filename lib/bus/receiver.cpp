#include "bus/receiver.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include "bus/decode.hpp"
#include "bus/spawn.hpp"
#include "bus/subscriber.hpp"
#include "core/error.hpp"

namespace ballbar {
namespace {

struct ParentGone {};

void send_frame(int socket, const ReceiverFrame& frame, std::span<const std::uint8_t> bytes) {
  iovec parts[2] = {{const_cast<ReceiverFrame*>(&frame), sizeof frame},
                    {const_cast<std::uint8_t*>(bytes.data()), bytes.size()}};
  msghdr message{};
  message.msg_iov = parts;
  message.msg_iovlen = bytes.empty() ? 1 : 2;
  // Blocks while the parent is busy; messages then wait in LCM's queues, whose capacity is stated.
  while (sendmsg(socket, &message, MSG_NOSIGNAL) < 0)
    if (errno != EINTR) throw ParentGone{};
}

/// Inodes of this process's sockets, to find its lines in /proc/self/net/udp.
std::set<std::string> own_sockets() {
  std::set<std::string> inodes;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const std::string link = std::filesystem::read_symlink(entry.path(), error).string();
    if (link.starts_with("socket:[")) inodes.insert(link.substr(8, link.size() - 9));
  }
  return inodes;
}

/// Datagrams that the kernel could not hold for this process: last column of /proc/self/net/udp.
std::int64_t kernel_drops() {
  const std::set<std::string> own = own_sockets();
  std::ifstream table("/proc/self/net/udp");
  std::string line;
  std::int64_t drops = 0;
  while (std::getline(table, line)) {
    std::istringstream words(line);
    std::vector<std::string> column;
    for (std::string word; words >> word;) column.push_back(word);
    if (column.size() >= 13 && own.contains(column[9]))
      drops += std::strtoll(column[12].c_str(), nullptr, 10);
  }
  return drops;
}

void hand_on(int socket, Channel channel, std::span<const std::uint8_t> bytes) {
  ReceiverFrame frame{.channel = channel};
  if (walk(channel, bytes, frame.reason)) return send_frame(socket, frame, bytes);
  frame.kind = ReceiverFrame::Kind::kRefused;
  send_frame(socket, frame, {});
}

std::int64_t steady_ms() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{1000} * now.tv_sec + now.tv_nsec / 1'000'000;
}

/// Memory of this process that is in use: second number of /proc/self/statm.
std::int64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t total = 0;
  std::int64_t resident = 0;
  statm >> total >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

/// Hands on what LCM still holds.
void empty_queue(Subscriber& subscriber) {
  pollfd ready{subscriber.fd(), POLLIN, 0};
  while (poll(&ready, 1, 20) > 0 && subscriber.handle()) {
  }
}

/// Returns when the parent asks for it or is gone, or when the bus or the memory ends.
void serve(Subscriber& subscriber, int socket) {
  constexpr std::int64_t kLookMs = 1000;
  constexpr std::int64_t kMaxBytes = std::int64_t{256}
                                     << 20;  // a flood of large messages or of channel names
  std::int64_t drops = 0;
  std::int64_t looked = steady_ms();
  for (;;) {
    pollfd ready[2] = {{subscriber.fd(), POLLIN, 0}, {socket, POLLIN, 0}};
    const int n = poll(ready, 2, static_cast<int>(kLookMs));
    if (n < 0 && errno != EINTR) return;
    if (n > 0 && ready[1].revents != 0)
      return empty_queue(subscriber);  // the parent never writes: it stops, or is gone
    if (n > 0 && ready[0].revents != 0 && !subscriber.handle()) return;
    if (steady_ms() - looked < kLookMs) continue;
    looked = steady_ms();
    if (resident_bytes() > kMaxBytes) return;  // started anew; a counted hole
    const std::int64_t now = kernel_drops();
    if (now != drops) send_frame(socket, {.kind = ReceiverFrame::Kind::kDrops, .number = drops = now}, {});
  }
}

}  // namespace

int run_receiver(const std::string& url, int socket) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_NAME, "ballbard-rx");
  for (const int number : {SIGTERM, SIGINT, SIGHUP})
    std::signal(number, SIG_IGN);  // the parent ends this process
  // liblcm speaks once per bad datagram, and at length where there is no route: the parent counts and says it
  // shorter.
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  try {
    Subscriber subscriber(
        url,
        [socket](Channel channel, std::span<const std::uint8_t> bytes, std::int64_t) {
          hand_on(socket, channel, bytes);
        },
        [socket] { send_frame(socket, {.kind = ReceiverFrame::Kind::kPulse}, {}); });
    send_frame(socket, {.kind = ReceiverFrame::Kind::kListening}, {});
    serve(subscriber, socket);
  } catch (const Error& error) {
    const std::string what = error.what();
    try {
      send_frame(socket, {.kind = ReceiverFrame::Kind::kFailed},
                 {reinterpret_cast<const std::uint8_t*>(what.data()), what.size()});
    } catch (const ParentGone&) {
    }
    return 3;
  } catch (const ParentGone&) {
  }
  return 0;
}

ReceiverProcess::ReceiverProcess(std::vector<std::string> command, std::string url)
    : command_(std::move(command)), url_(std::move(url)) {}

ReceiverProcess::~ReceiverProcess() { stop(); }

void ReceiverProcess::start() {
  stop();
  int pair[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0)
    throw Error(Cause::kWorld, std::string("receiver: no socket pair: ") + std::strerror(errno));
  constexpr int kChildSocket = 3;
  std::vector<std::string> words = command_;
  words.push_back(url_);
  words.push_back(std::to_string(kChildSocket));
  const int error = spawn({.command = std::move(words), .files = {{pair[1], kChildSocket}}}, pid_);
  close(pair[1]);
  if (error != 0) {
    close(pair[0]);
    pid_ = -1;
    throw Error(Cause::kWorld, "receiver: " + command_[0] + " cannot be started: " + std::strerror(error));
  }
  socket_ = pair[0];
  fcntl(socket_, F_SETFL, O_NONBLOCK);
}

void ReceiverProcess::stop() {
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
  if (pid_ > 0) {
    kill(pid_, SIGKILL);  // it holds nothing that must be saved
    waitpid(pid_, nullptr, 0);
  }
  pid_ = -1;
}

void ReceiverProcess::drain(const FrameHandler& handler, std::uint64_t most_us) {
  shutdown(socket_, SHUT_WR);
  const std::int64_t end = steady_ms() + static_cast<std::int64_t>(most_us / 1000);
  while (steady_ms() < end) {
    pollfd ready{socket_, POLLIN, 0};
    if (poll(&ready, 1, 50) > 0 && !read(handler, 1000)) return;
  }
}

bool ReceiverProcess::read(const FrameHandler& handler, int most) {
  static_assert(std::is_trivially_copyable_v<ReceiverFrame>);
  std::vector<std::uint8_t> buffer(sizeof(ReceiverFrame) + kMaxMessageBytes);
  for (int i = 0; i < most; ++i) {
    const ssize_t size = recv(socket_, buffer.data(), buffer.size(), 0);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return errno == EAGAIN;
    if (static_cast<std::size_t>(size) < sizeof(ReceiverFrame)) return false;
    ReceiverFrame frame;
    std::memcpy(&frame, buffer.data(), sizeof frame);
    handler(frame, {buffer.data() + sizeof frame, static_cast<std::size_t>(size) - sizeof frame});
  }
  return true;
}

}  // namespace ballbar

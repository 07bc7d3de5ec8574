#pragma once
/// The receive path of liblcm in a process of its own, for one malformed datagram of 20 bytes kills any
/// process that receives with it. The child only receives, walks the bytes and hands them on; its death costs
/// what it held.

#include <sys/types.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bus/channels.hpp"

namespace ballbar {

/// What the child says, one frame a datagram on a SOCK_SEQPACKET pair.
struct ReceiverFrame {
  enum class Kind : std::uint8_t {
    kListening,  ///< subscribed
    kMessage,    ///< bytes of one message that passed the walk
    kRefused,    ///< one that did not: channel and reason
    kDrops,      ///< datagrams that the kernel could not hold since the start: `number`
    kPulse,      ///< the service's own status came back: the bus is heard
    kFailed,     ///< the bus cannot be opened: bytes say why; the child ends
  };
  Kind kind = Kind::kMessage;
  Channel channel = Channel::kBallbar;
  Refusal reason = Refusal::kTruncated;
  std::int64_t number = 0;
};

using FrameHandler = std::function<void(const ReceiverFrame&, std::span<const std::uint8_t> bytes)>;

/// The child's main: never returns before the parent is gone or the bus failed.
/// @param socket  the child's end of the pair
/// @return exit code
int run_receiver(const std::string& url, int socket);

/// The parent's side.
class ReceiverProcess {
 public:
  /// @param command  program and arguments; the URL and the socket's number are appended
  ReceiverProcess(std::vector<std::string> command, std::string url);
  ~ReceiverProcess();  ///< stops the child
  ReceiverProcess(const ReceiverProcess&) = delete;
  ReceiverProcess& operator=(const ReceiverProcess&) = delete;

  /// Starts a child; a former one is stopped first.
  /// @throws Error(kWorld) where no process can be made
  void start();
  void stop();

  int fd() const { return socket_; }  ///< readable when frames wait or the child is gone; -1 before start()
  pid_t pid() const { return pid_; }

  /// Asks the child to hand over what it still holds, and reads until it has done so.
  /// @param most_us  how long at most
  void drain(const FrameHandler& handler, std::uint64_t most_us);

  /// Hands over frames that wait, at most `most`. False when the child is gone (all of its frames were read).
  bool read(const FrameHandler& handler, int most);

 private:
  std::vector<std::string> command_;
  std::string url_;
  int socket_ = -1;
  pid_t pid_ = -1;
};

}  // namespace ballbar

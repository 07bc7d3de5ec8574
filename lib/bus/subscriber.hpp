#pragma once
/// The input channels of one LCM URL as raw bytes, inside this process.
/// Live `udpm://` goes through ReceiverProcess: one malformed datagram kills any process that receives with
/// liblcm. Logs are read by read_log(). `memq://` is for unit tests.

#include <functional>
#include <memory>
#include <string>

#include "bus/channels.hpp"

namespace ballbar {

class Subscriber {
 public:
  /// Opens the bus and subscribes raw to all input channels with their stated queue capacities.
  /// On udpm this takes up to 10 s where multicast does not come back.
  /// @throws Error(kWorld) with the URL and what to do
  /// @param pulse  where not empty: called for every message on kPulseChannel as well
  Subscriber(const std::string& url, RawHandler handler, std::function<void()> pulse = {});
  ~Subscriber();

  /// Becomes readable when handle() has something to do. Never -1.
  int fd() const;

  /// Sends on the same bus. With memq:// it comes back here, and nowhere else.
  void publish(Channel channel, std::span<const std::uint8_t> bytes);

  /// Waits for one message and hands it to the handler. False where the bus is no more.
  bool handle();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ballbar

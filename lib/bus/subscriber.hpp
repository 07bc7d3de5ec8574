#pragma once
/// The input channels of one LCM URL as raw bytes, inside this process.
/// For `file://` (replay) and `memq://` (unit tests). Live `udpm://` goes through ReceiverProcess: one
/// malformed datagram kills any process that receives with liblcm.

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "bus/channels.hpp"

namespace ballbar {

/// @param arrival_us  LCM's receive time; in a replay the time at which the log's writer received it
using RawHandler = std::function<void(Channel, std::span<const std::uint8_t> bytes, std::int64_t arrival_us)>;

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

  /// Waits for one message and hands it to the handler. False at the end of a log.
  bool handle();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ballbar

#pragma once
/// Samples in SI to the wire's bytes: what decode() takes apart.

#include <cstdint>
#include <vector>

#include "bus/channels.hpp"
#include "core/samples.hpp"

namespace ballbar {

/// @param message  of a generated type, with getEncodedSize() and encode()
template <typename Message>
std::vector<std::uint8_t> bytes_of(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

struct Encoded {
  Channel channel = Channel::kBallbar;
  std::vector<std::uint8_t> bytes;
};

/// A temperature that was not measured is NaN on the wire.
Encoded encode(const Sample& sample);

}  // namespace ballbar

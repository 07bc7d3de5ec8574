#pragma once
/// Bytes from anybody to samples in SI, or the reason why not. Never throws, never reads outside, never
/// allocates by a length that was not checked: LCM's generated decoders trust array lengths, so every message
/// is walked first.

#include <span>
#include <string>
#include <variant>

#include "bus/channels.hpp"
#include "core/samples.hpp"

namespace ballbar {

using Decoded = std::variant<Sample, Refusal>;

/// The bounded walk alone: fingerprint, strings, counts, end of the walk = size. Nothing is allocated.
/// @return true where the generated decoder may be called; else `reason` says why not
bool walk(Channel channel, std::span<const std::uint8_t> bytes, Refusal& reason);

/// Walk, decode, check of every value, conversion to SI.
Decoded decode(Channel channel, std::span<const std::uint8_t> bytes);

/// A free label as it may stand in a table, a log and JSON: what is no printable UTF-8 becomes '?'.
std::string printable(const std::string& text);

}  // namespace ballbar

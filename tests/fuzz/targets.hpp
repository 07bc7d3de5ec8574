#pragma once
/// Every input from outside, as a function of bytes. It may refuse them with the error that it states;
/// anything else that happens is a finding.

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace ballbar::fuzz {

using Bytes = std::span<const std::uint8_t>;

struct Target {
  std::string_view name;  ///< also the folder of its corpus
  void (*run)(Bytes);
};

void message(Bytes bytes);  ///< first byte: channel
void marks(Bytes bytes);    ///< a sequence of marks and samples through the assembler
void log_file(Bytes bytes);
void config(Bytes bytes);
void urdf(Bytes bytes);
void rule(Bytes bytes);
void b5r(Bytes bytes);
void csv(Bytes bytes);
void poses(Bytes bytes);
void trace(Bytes bytes);  ///< first byte: coding

inline constexpr std::array<Target, 10> kTargets{{{"message", message},
                                                  {"marks", marks},
                                                  {"log", log_file},
                                                  {"config", config},
                                                  {"urdf", urdf},
                                                  {"rule", rule},
                                                  {"b5r", b5r},
                                                  {"csv", csv},
                                                  {"poses", poses},
                                                  {"trace", trace}}};

}  // namespace ballbar::fuzz

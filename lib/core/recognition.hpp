#pragma once
/// The door through which joints without marks become circles: the assembler calls it, pipeline/ implements
/// it.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/spec.hpp"

namespace ballbar {

/// A configured circle that the joints have driven: its whole arc, and what of the overshoots was driven.
struct RecognisedCircle {
  std::size_t test = 0;       ///< index in RobotSpec::tests
  int direction = 0;          ///< +1 or -1
  std::int64_t begin_us = 0;  ///< of the first joint sample that belongs to it
  std::int64_t end_us = 0;    ///< of the last one
  double feed = 0.0;          ///< [m/s] mean over the arc
};

class Recogniser {
 public:
  virtual ~Recogniser() = default;

  /// Takes one joint sample; circles that are over are appended to `found`.
  /// @param time_us  rising from call to call
  /// @param q        [rad] in the robot's joint convention
  virtual void take(std::int64_t time_us, std::span<const double> q,
                    std::vector<RecognisedCircle>& found) = 0;

  /// JOINTS fell silent: what is complete is over, the rest is forgotten.
  virtual void end_path(std::vector<RecognisedCircle>& found) = 0;

  /// Forgets the path so far.
  virtual void reset() = 0;

  /// Circles to come begin here or later: older samples are not needed any more. Nothing: none is needed.
  virtual std::optional<std::int64_t> needed_since_us() const = 0;
};

/// Null where a robot has no circle to recognise.
using MakeRecogniser = std::function<std::unique_ptr<Recogniser>(const RobotSpec&)>;

}  // namespace ballbar

#pragma once
/// Which effect a change of the harmonics looks like.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "gap/candidates.hpp"

namespace ballbar {

/// Orders that a change is seen in: order 1 is how the ball was set up, and 0 how the bar was.
inline constexpr int kFirstChangedOrder = 2, kLastChangedOrder = 10;

/// How the harmonics of one test and direction have changed: cos 2, sin 2, cos 3, ... of new minus old mean.
struct HarmonicChange {
  std::size_t observation = 0;  ///< whose motion it is of
  Eigen::VectorXd step;         ///< [m] 2 (kLastChangedOrder - kFirstChangedOrder + 1)
  Eigen::VectorXd sd;           ///< [m] of each, of the scatter of the runs
};

/// An effect that a change may be, or that went away.
struct Likeness {
  std::string effect, kind;
  int joint = 0;
  double explains = 0.0;  ///< share of the change's sum of squares, weighed with the scatter
  double size = 0.0;      ///< [m] root mean square of it over the circles
  double worse = 0.0;     ///< by how much less likely than the best [ln]
  std::vector<std::pair<std::string, double>>
      parameters;  ///< change of each, in the unit of the name; where linear
};

/// Every effect of the catalogue and the joints' zeros, each alone, fitted to all changes at once: the best
/// first, only those that explain something. Linear about the robot as configured, so sizes are those of
/// small changes.
std::vector<Likeness> looks_like(const GapModel& model, const std::vector<Observation>& observations,
                                 const std::vector<HarmonicChange>& changes);

}  // namespace ballbar

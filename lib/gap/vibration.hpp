#pragma once
/// A line at one frequency in time, whatever the feed and with a new phase in every lap: what the arm or its
/// cell does by itself (physics-gap.md 3, row 14).

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/estimate.hpp"
#include "gap/observation.hpp"

namespace ballbar {

struct Vibration {
  Estimate frequency;  ///< [Hz]
  Estimate amplitude;  ///< [m] along the bar, half of peak to peak, root mean square over the laps
  double z = 0.0;  ///< standard deviations by which the laps' energy at this frequency exceeds their noise
};

/// Sums, over all laps, the energy of three neighbouring coefficients about each frequency, each over the
/// median of the coefficients beside them, and takes the frequency with the most.
/// @param predicted  [m] coefficients that the model gives each observation, without what is looked for
/// @return nothing where no frequency stands out
std::optional<Vibration> find_vibration(const std::vector<Observation>& observations,
                                        const std::vector<Eigen::VectorXd>& predicted);

}  // namespace ballbar

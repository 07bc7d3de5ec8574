#pragma once
/// The Gaussian profile filter of ISO 16610-21 for roundness, on uneven angles.

#include <Eigen/Core>
#include <vector>

#include "numerics/fit_status.hpp"

namespace ballbar {

struct FilteredProfile {
  FitStatus status = FitStatus::kTooFewPoints;
  Eigen::VectorXd value;      ///< one per sample; NaN where `defined` is false
  std::vector<bool> defined;  ///< false within one wavelength of the cut-off from an end of an open profile
};

/// Long-wave part of a profile. An undulation of k per revolution passes with the share 2^-(k/cutoff)^2: half
/// at the cut-off (metrology.md 2: 15, 50, 150 or 500 undulations per revolution are usual). Every sample
/// counts with the stretch of angle that is nearest to it, so uneven angles do no harm; the weights add up to
/// one everywhere, so a constant passes unchanged.
///
/// A profile whose angles leave no hole wider than the step that the cut-off asks for is closed: it has no
/// ends. Any other is open: its filtered value is not defined within one wavelength of the cut-off (360 deg /
/// cutoff) from its ends, where the weights (cut at less than 1e-6 of their sum) would reach beyond them.
///
/// @param angle   n values [rad] in any sequence and of any turn; folded onto one revolution
/// @param value   n values
/// @param cutoff  undulations per revolution, > 0
/// @return kTooFewPoints where neighbouring samples are farther apart than a seventh of the wavelength (but
/// for the one
///         hole of an open profile), or an open profile is too short to have a defined part
/// @throws std::invalid_argument for other sizes, a value that is not finite, or a cut-off that is not in (0,
/// 1000]
FilteredProfile gaussian_filter(const Eigen::VectorXd& angle, const Eigen::VectorXd& value, double cutoff);

}  // namespace ballbar

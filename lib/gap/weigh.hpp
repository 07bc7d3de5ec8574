#pragma once
/// Inside gap/ only: how much speaks for each effect that was found, how large it is, and what would do as
/// well.

#include <vector>

#include "gap/gap_fit.hpp"

namespace ballbar {

/// One effect beside the named ones, weighed at the fit.
struct Weighed {
  std::size_t candidate = 0;
  double log_odds = 0.0;     ///< of the named set with this one instead of the one it replaces
  double resemblance = 0.0;  ///< with the one that it replaces, of what the baseline leaves of both
};

struct Weights {
  std::vector<double> evidence;             ///< ln of the odds for each named effect
  std::vector<double> size;                 ///< [m] of each: sizes()
  std::vector<std::vector<Weighed>> twins;  ///< of each: candidates that would do nearly as well
};

/// Root mean square over the arcs [m] of what each named effect does and the baseline cannot take up.
std::vector<double> sizes(const GapFitter& fitter, const GapFit& fit);

Weights weigh(const GapFitter& fitter, const GapFit& fit, const std::vector<Candidate>& candidates);

}  // namespace ballbar

#pragma once
/// What a fit says about itself where the points hold no answer.

namespace ballbar {

enum class FitStatus {
  kOk,
  kTooFewPoints,    ///< fewer points than the fit has unknowns (and, where it estimates noise, one more)
  kIllConditioned,  ///< enough points, but they do not determine the answer (collinear, all alike, no
                    ///< convergence)
};

}  // namespace ballbar

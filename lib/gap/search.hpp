#pragma once
/// Inside gap/ only: the search for effects in rounds, each with a search by evidence, a nonlinear refit, and the
/// kinds of lost motion weighed against each other.

#include <vector>

#include "gap/gap_fit.hpp"
#include "numerics/evidence_search.hpp"

namespace ballbar {

struct Found {
  GapFit fit;                          ///< with shape freedom
  std::vector<Candidate> candidates;   ///< of the last round
  std::vector<std::size_t> named;      ///< fit.named[i] is candidates[named[i]], or of its family
  EvidenceProblem problem;             ///< of the last round, whitened
  EvidenceResult evidence;             ///< of the last round
  std::vector<double> size;            ///< [m] of each named effect: what the baseline cannot take up
};

Found search_effects(const GapFitter& fitter, std::vector<Candidate> candidates);

}  // namespace ballbar

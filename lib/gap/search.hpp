#pragma once
/// Inside gap/ only: the search for effects in rounds, each with a search by evidence, a nonlinear refit, and
/// the kinds of lost motion weighed against each other.

#include <optional>
#include <vector>

#include "gap/gap_fit.hpp"
#include "numerics/evidence_search.hpp"

namespace ballbar {

struct Found {
  GapFit fit;               ///< with shape freedom
  EvidenceResult evidence;  ///< of the last round
};

/// @param curve  searched for beside the catalogue; nothing: the catalogue alone
/// @param known  of these observations, where to begin: all of it competes again; null: with nothing named
Found search_effects(const GapFitter& fitter, const std::vector<Candidate>& candidates,
                     const std::optional<Curve>& curve = {}, const GapFit* known = nullptr);

/// Observations whose noise also holds what a formula that is a little wrong leaves of the signal that it
/// explains.
std::vector<Observation> with_model_form(const GapFitter& fitter, const GapFit& fit);

/// A curve that is worth a search of its own, the best first (physics-gap.md 5, step 8).
std::vector<Curve> promising_curves(const GapFitter& fitter, const std::vector<Candidate>& candidates,
                                    std::size_t most);

}  // namespace ballbar

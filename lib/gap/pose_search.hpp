#pragma once
/// Which effects a set of poses needs beside its set-ups, zero offsets and geometry.

#include <string>
#include <vector>

#include "gap/pose_fit.hpp"
#include "numerics/evidence_search.hpp"

namespace ballbar {

/// Every zero offset, and every length and twist of the table; beta only of axes that are nearly parallel.
std::vector<PoseTerm> geometry_terms(const Chain& chain);

/// What else the rows can show, without ripples and jumps, which are looked for.
std::vector<PoseTerm> effect_candidates(const PoseRows& rows, const std::vector<PoseRow>& fitted);

/// Curves that stand for what no other candidate is: an angle error of one joint by its angle, or a movement
/// in time. They compete, so that what is outside the catalogue is not given its names.
std::vector<PoseTerm> curve_candidates(const std::vector<PoseRow>& fitted);

struct PoseSearchOptions {
  double least_sd = 0.0;   ///< [m] of one reading, from repeats; 0: not known
  double material = 0.05;  ///< least size of what an effect explains, in standard deviations of the readings
  double most_cycles = 250;  ///< of a ripple, per turn of its joint
  int rounds = 60;
};

/// Effects are looked for around `fit`, everything in it eliminated jointly; rounds until none is found.
/// Ripples are looked for at any rate, by a scan in each joint's phase; jumps at any row.
/// @return fit.state with the terms that were found, before the refit
PoseState search_poses(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseFit& fit,
                       const std::vector<PoseTerm>& candidates, const PoseSearchOptions& options);

/// The same by evidence among given terms only, at once: no scans.
PoseState select_terms(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseFit& fit,
                       const std::vector<PoseTerm>& candidates, const PoseSearchOptions& options);

/// The same with the rates of its ripples moved to where all together fit best, by one step of Gauss and
/// Newton each call; values are to be fitted again. A scan finds them without elimination, so not quite.
PoseState refine_rates(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseFit& fit);

/// What each term of a state is worth.
struct PoseTermWorth {
  double evidence = 0.0;      ///< ln of odds with it against without it, all else refitted
  double contribution = 0.0;  ///< [m] root mean square of what nothing else explains
  double share = 0.0;         ///< of everything that all terms together take from the readings, squared
};
/// @param rivals    what else could be; @param confused  if not null: per term, those of them that it cannot
/// be
///                  told from. Ripples are told apart by their rate.
std::vector<PoseTermWorth> term_worth(const PoseModel& model, const std::vector<PoseRow>& rows,
                                      const PoseFit& fit, const std::vector<PoseTerm>& rivals,
                                      std::vector<std::vector<PoseTerm>>* confused);

}  // namespace ballbar

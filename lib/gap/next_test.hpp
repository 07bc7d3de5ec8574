#pragma once
/// Which test to drive next: what would tell effects apart that those driven so far do not.
///
/// Every test says something of the joints' zeros, the bar and the effects: its normal equations, from which
/// its own ball and clock are eliminated. These add up, so any set of tests is a sum, and the separation of
/// two effects a Schur complement of it (physics-gap.md 9, last row: greedy D-design).

#include <Eigen/Core>
#include <string>
#include <vector>

#include "gap/candidates.hpp"
#include "gap/diagnosis.hpp"
#include "gap/gap_fit.hpp"
#include "gap/proposed_tests.hpp"

namespace ballbar {

/// An effect at the size at which it is looked at, as columns: what it does in full; of a sine whose phase is
/// open, sine and cosine.
struct Suspect {
  std::string label;
  std::vector<Effect> columns;
  bool positive = false;  ///< of one column: it has this sign, or none
};

Suspect suspect_of(const Candidate& candidate, double size = 1.0);

/// What a set of tests says of zeros, bar's zero and scale, and the columns of suspects, at their sizes.
using Information = Eigen::MatrixXd;

/// @param observations  with variances; their balls and clocks are eliminated
Information information_of(const GapModel& model, const std::vector<Observation>& observations,
                           const GapState& state, const std::vector<Suspect>& suspects);

/// How well two effects are told apart.
struct Separation {
  double noise = 0.0;  ///< [standard deviations] of noise: root of the chi2 by which the wrong one fits worse
  double sure = 0.0;   ///< the same where a formula too may be wrong: by 2 % of its effect, lost motion and
                       ///< compliance by 10 %
};

/// Separations by the sum of what tests say.
class Judge {
 public:
  /// @param all  sum of informations about these suspects
  Judge(const Information& all, const std::vector<Suspect>& suspects, int joints);

  /// Of a from the best that b can do, with `others` free as well; of a sine with an open phase, at the phase
  /// that is told apart worst.
  Separation of(std::size_t a, std::size_t b, const std::vector<std::size_t>& others = {}) const;

  /// Of a from nothing but zeros and set-up.
  Separation of(std::size_t a) const { return of(a, a); }

  /// The size, of the one given, at which b comes nearest to a; b has one column.
  double like(std::size_t a, std::size_t b) const;

 private:
  const std::vector<Suspect>& suspects_;
  std::vector<Eigen::Index> begin_;
  Eigen::MatrixXd gram_;
};

/// Separations from here on count as told apart.
inline constexpr double kSure = 3.0;

struct RankedTest {
  ProposedTest proposed;
  double noise = 0.0;       ///< [standard deviations] between the two, with this test beside those driven
  double sure = 0.0;        ///< see Separation
  std::size_t decided = 0;  ///< pairs that are told apart with this test and were not before
};

/// A pair, and which tests would tell it apart, the best first.
struct PairPlan {
  std::string a, b;
  Separation now;
  std::vector<RankedTest> tests;
};

/// For every pair that a diagnosis cannot tell apart.
/// @param driven    what was fitted, with its noise
/// @param proposed  from proposed_tests()
std::vector<PairPlan> plan_for(const GapModel& model, const std::vector<Observation>& driven,
                               const Diagnosis& diagnosis, const std::vector<ProposedTest>& proposed,
                               const Progress& progress = {});

/// Something in it cannot be told from something else: there is a next test to plan.
bool has_twins(const Diagnosis& diagnosis);

/// Writes the best test of each pair into `to_tell_apart`.
void suggest(const std::vector<PairPlan>& plans, Diagnosis& diagnosis);

/// In one sentence: what to drive.
std::string sentence_of(const RankedTest& best, const Separation& now);

struct RobotPlan {
  std::size_t visible = 0,
              effects = 0;           ///< effects that show with the tests driven, at typical sizes; of all
  std::size_t pairs = 0, apart = 0;  ///< pairs that any test shows, and those told apart by the tests driven
  std::vector<RankedTest> tests;     ///< to be driven one after another, the best first
  std::size_t apart_with_all = 0;    ///< pairs told apart when all of them are driven
  std::vector<std::string> never;    ///< "a and b": told apart by none of the proposed tests
};

/// The tests that tell most of the catalogue apart, chosen one after another.
/// @param driven    configured or recorded; may be empty
/// @param suspects  at typical sizes; at least two
/// @param most      tests to choose
RobotPlan plan_for_robot(const GapModel& model, const std::vector<Observation>& driven,
                         const std::vector<Suspect>& suspects, const std::vector<ProposedTest>& proposed,
                         std::size_t most, const Progress& progress = {});

/// The catalogue's effects at typical sizes, but for those that hang on a moment of a series.
/// @param names  "joint_lost_motion:2", "servo_lag"; empty: all
/// @throws Error(kInput) for a name that matches none
std::vector<Suspect> suspects_of(const GapModel& model, const std::vector<std::string>& names);

}  // namespace ballbar

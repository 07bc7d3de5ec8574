#pragma once
/// Inside gap/ only: poses linearised once, so that effects can be weighed, taken in and weighed again
/// without going back to the rows.

#include <Eigen/Core>
#include <vector>

#include "gap/pose_fit.hpp"
#include "numerics/evidence_search.hpp"

namespace ballbar {

/// Columns of terms are per typical size. What is taken in is eliminated with its prior from everything else.
class PoseElimination {
 public:
  /// Around `fit`: its set-ups are always in, and its terms are the first candidates, taken.
  PoseElimination(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseFit& fit,
                  double least_sd);

  int add(const PoseTerm& term);    ///< @return the candidate's number
  void drop_candidates(int first);  ///< those from this number on that are not taken
  void take(int candidate);         ///< from now on eliminated like all that is in
  void release(int candidate);      ///< the reverse

  /// The fit of all that is in; sets residual() and sd().
  void solve();
  const Eigen::VectorXd& residual() const { return residual_; }
  double sd() const { return sd_; }  ///< [m] as PoseFit::sd
  const std::vector<PoseGeometry>& geometry() const { return geometry_; }

  /// Candidates against what is in.
  EvidenceProblem problem(const std::vector<int>& candidates) const;

  const PoseTerm& term(int candidate) const { return candidates_[static_cast<std::size_t>(candidate)].term; }
  bool taken(int candidate) const { return candidates_[static_cast<std::size_t>(candidate)].taken; }
  int candidates() const { return static_cast<int>(candidates_.size()); }

  /// The state with the solution's values and the taken candidates as terms.
  PoseState state() const;

 private:
  struct Candidate {
    PoseTerm term;
    Eigen::Index begin = 0;
    bool taken = false;
  };
  std::vector<Eigen::Index> columns_in() const;

  const PoseModel& model_;
  const std::vector<PoseRow>& rows_;
  PoseState start_;
  double least_sd_;
  std::vector<PoseGeometry> geometry_;
  Eigen::VectorXd data_;            ///< residual at start_ with all terms at 0, as far as they are linear
  Eigen::MatrixXd columns_, gram_;  ///< of everything; used_ columns hold
  Eigen::VectorXd right_;           ///< columns' x data_
  Eigen::VectorXd weight_;          ///< 1 / prior variance
  Eigen::Index used_ = 0;
  std::vector<Candidate> candidates_;
  Eigen::VectorXd solution_, residual_;
  double sd_ = 0.0;
};

}  // namespace ballbar

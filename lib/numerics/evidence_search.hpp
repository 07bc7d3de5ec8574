#pragma once
/// Which groups of columns a whitened record needs beside its baseline, by evidence. Source:
/// physics-gap.md 5, steps 3 and 4. The baseline is never fitted first: its parameters and the candidates are
/// confounded, and only their joint fit with priors of physical size is honest (Brynjarsdottir and O'Hagan
/// 2014, Inverse Problems 30, 114007).

#include <Eigen/Core>
#include <vector>

namespace ballbar {

/// The candidates after the baseline has been integrated out, y ~ N(0, C) with C = I + B Sigma^2 B'.
/// A group is a run of neighbouring columns, counted from 0.
struct EvidenceProblem {
  Eigen::MatrixXd gram;             ///< X' C^-1 X, p x p; its diagonal is what the baseline leaves of X'X
  Eigen::VectorXd projection;       ///< X' C^-1 y, p
  Eigen::VectorXd raw_energy;       ///< p: squared norm of every column before, for the share that is left
  double chi2 = 0.0;                ///< y' C^-1 y
  std::vector<Eigen::Index> begin;  ///< first column of each group, and p at the end

  int groups() const { return static_cast<int>(begin.size()) - 1; }
  Eigen::Index width(int group) const;
};

/// All columns and y whitened alike: noise of unit variance.
/// @param y           n
/// @param baseline    n x k, per unit of each parameter; k = 0 is allowed
/// @param prior_sd    k values >= 0, of the baseline's parameters
/// @param candidates  n x p, per typical size of each effect
/// @param widths      columns of each group, >= 1, p in all
/// @throws std::invalid_argument for sizes that do not match or values that are not finite
EvidenceProblem eliminate_baseline(const Eigen::VectorXd& y, const Eigen::MatrixXd& baseline,
                                   const Eigen::VectorXd& prior_sd, const Eigen::MatrixXd& candidates,
                                   const std::vector<int>& widths);

struct EvidenceOptions {
  double prior_sd = 2.0;  ///< tau > 0, of every coefficient, in typical sizes
  int max_groups = 9;     ///< >= 0
};

/// A set of groups, and what speaks for it.
struct Hypothesis {
  std::vector<int> groups;    ///< rising
  double log_evidence = 0.0;  ///< ln of the density of y with these groups over that with the baseline alone
  double log_odds = 0.0;      ///< log_evidence + groups * ln(0.5 / number of candidates): prior included
  double probability = 0.0;   ///< among all sets that the search has visited
};

/// Coefficients of a set of groups, given that it is the right one. The baseline's doubt is in the
/// covariance.
struct EvidencePosterior {
  Eigen::VectorXd mean;        ///< in typical sizes, columns of the groups in rising sequence
  Eigen::MatrixXd covariance;  ///< of mean
};

struct EvidenceResult {
  std::vector<Hypothesis> hypotheses;  ///< the best first, then all others less than kAlternative behind it
  EvidencePosterior posterior;         ///< of the best
  Eigen::VectorXd inclusion;           ///< per group: probability of the visited sets that hold it
  int visited = 0;                     ///< sets weighed

  const Hypothesis& best() const { return hypotheses.front(); }
};

inline constexpr double kAlternative = 5.0;  ///< [ln of odds]

/// 1/2 b' A^-1 b - 1/2 ln |A| with A = tau^2 gram + I, b = tau projection of the columns of the set: exact
/// for coefficients ~ N(0, tau^2). @throws std::invalid_argument for a group that is not there or is there
/// twice
double log_evidence(const EvidenceProblem& problem, const std::vector<int>& groups, double prior_sd);

/// @throws std::invalid_argument as log_evidence
EvidencePosterior evidence_posterior(const EvidenceProblem& problem, const std::vector<int>& groups,
                                     double prior_sd);

/// Beam search from the empty set (which is visited too): 10 sets are extended up to size 3, 3 beyond; at
/// each size all swaps of one group of the best 4 (beyond size 3: of the best one) are tried. Groups that are
/// exact null directions, zero or copies of each other do no harm. Deterministic; where two sets are equally
/// likely to the last bit, the one with the lower numbers comes first.
/// Not exhaustive: effects that nearly cancel each other, or whose sum many other candidates look like, can
/// stay unvisited; then the best set named is a wrong one, and probabilities hold among the visited only.
/// @throws std::invalid_argument for options out of range
EvidenceResult search_evidence(const EvidenceProblem& problem, const EvidenceOptions& options = {});

/// How alike two groups are after the baseline: groups x groups, symmetric, 1 on the diagonal. The cosine of
/// the columns; for groups of several the first canonical correlation, so 1 says that some pattern of the one
/// is a pattern of the other. 0 with a group of which the baseline leaves nothing but rounding.
Eigen::MatrixXd resemblance(const EvidenceProblem& problem);

inline constexpr double kNotToldApart = 0.97;

/// Per group, the others it cannot be told from: resemblance above kNotToldApart. Never report one without
/// them (physics-gap.md 4).
std::vector<std::vector<int>> not_told_apart(const Eigen::MatrixXd& resemblance);

}  // namespace ballbar

#pragma once
/// Random records with a baseline and candidates, all drawn from their priors or planted.

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

#include "numerics/evidence_search.hpp"

namespace ballbar {

struct EvidenceCase {
  Eigen::VectorXd y;
  Eigen::MatrixXd baseline;
  Eigen::VectorXd prior_sd;
  Eigen::MatrixXd candidates;
  std::vector<int> widths;

  EvidenceProblem reduced() const { return eliminate_baseline(y, baseline, prior_sd, candidates, widths); }

  int groups() const { return static_cast<int>(widths.size()); }
  Eigen::Index begin(int group) const {
    Eigen::Index at = 0;
    for (int g = 0; g < group; ++g) at += widths[static_cast<std::size_t>(g)];
    return at;
  }
  auto columns(int group) const {
    return candidates.middleCols(begin(group), widths[static_cast<std::size_t>(group)]);
  }
};

inline Eigen::MatrixXd normal_matrix(std::mt19937_64& random, Eigen::Index rows, Eigen::Index cols) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd m(rows, cols);
  for (double& v : m.reshaped()) v = normal(random);
  return m;
}

/// A baseline that is strong against the noise, candidates that lean on it and on each other, y of baseline
/// and noise alone.
/// @param size  norm of a candidate's own part, about: its whitened size
inline EvidenceCase draw_case(std::mt19937_64& random, Eigen::Index rows, Eigen::Index k, int groups,
                              double size) {
  EvidenceCase c;
  c.baseline = 50.0 * normal_matrix(random, rows, k);
  c.prior_sd = Eigen::VectorXd::LinSpaced(k, 0.5, 3.0);
  for (int g = 0; g < groups; ++g) c.widths.push_back(1 + static_cast<int>(random() % 2));
  const Eigen::Index p = c.begin(groups);
  const double unit = size / std::sqrt(static_cast<double>(rows));
  const Eigen::MatrixXd common = normal_matrix(random, rows, 3);
  c.candidates = unit * (normal_matrix(random, rows, p) + 0.5 * common * normal_matrix(random, 3, p)) +
                 c.baseline * normal_matrix(random, k, p);
  c.y = c.baseline * c.prior_sd.cwiseProduct(normal_matrix(random, k, 1)) + normal_matrix(random, rows, 1);
  return c;
}

}  // namespace ballbar

#pragma once
/// Inside gap/ only: what a search by evidence is made of at one state of a fit.

#include <vector>

#include "gap/gap_fit.hpp"

namespace ballbar {

/// Whitened columns of many candidates side by side: rows x sum of widths.
struct Columns {
  Eigen::MatrixXd all;
  std::vector<int> widths;
  std::vector<Eigen::Index> begin;
};

/// @param now  coefficients of each candidate at which its columns are taken; empty: at its typical size
Columns all_columns(const GapFitter& fitter, const Linearised& at, const std::vector<Candidate>& candidates,
                    const std::vector<Eigen::VectorXd>& now, Slope slope);

/// What is beside the candidates: baseline and shape freedom, and their standard deviations.
struct Nuisances {
  Eigen::MatrixXd columns;
  Eigen::VectorXd sd;
};

Nuisances nuisances_of(const GapFitter& fitter, const Linearised& at, const GapPriors& priors);

/// Residual and baseline about zero, and whatever is in the model: all compete again with all others.
Eigen::VectorXd about_zero(const GapFitter& fitter, const Linearised& at, const GapFit& fit);

/// Whether one would replace the other: lost motion of one joint is named once.
bool rivals(const Candidate& a, const Candidate& b);

/// Zeros and set-up alone.
GapFit baseline_fit(const GapFitter& fitter);

}  // namespace ballbar

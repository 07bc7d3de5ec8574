#include "gap/search_problem.hpp"

namespace ballbar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Columns all_columns(const GapFitter& fitter, const Linearised& at, const std::vector<Candidate>& candidates,
                    const std::vector<VectorXd>& now, Slope slope) {
  Columns columns;
  Index total = 0;
  for (const Candidate& candidate : candidates) {
    columns.begin.push_back(total);
    columns.widths.push_back(candidate.width());
    total += candidate.width();
  }
  columns.all.resize(fitter.rows(), total);
  for (std::size_t i = 0; i < at.tangents.size(); ++i) {
    const Tangent& tangent = at.tangents[i];
    Drive drive = tangent.drive();
    MatrixXd values(tangent.time.size(), total);
    for (std::size_t c = 0; c < candidates.size(); ++c)
      values.middleCols(columns.begin[c], columns.widths[c]) =
          columns_of(fitter.model(), tangent, drive, candidates[c], now[c], slope);
    columns.all.middleRows(at.begin[i], fitter.observations()[i].measured.size()) =
        fitter.whitened(i, values);
  }
  return columns;
}

Nuisances nuisances_of(const GapFitter& fitter, const Linearised& at, const GapPriors& priors) {
  Nuisances all;
  all.columns.resize(at.baseline.rows(), at.baseline.cols() + at.shape.cols());
  all.columns << at.baseline, at.shape;
  const VectorXd base = fitter.baseline_sd(priors);
  all.sd.resize(all.columns.cols());
  all.sd << base, VectorXd::Ones(at.shape.cols());
  return all;
}

VectorXd about_zero(const GapFitter& fitter, const Linearised& at, const GapFit& fit) {
  VectorXd y = at.residual + at.baseline * baseline_of(fit.state);
  for (const NamedEffect& named : fit.named)
    y += fitter.contribution(at, named.candidate.with(named.coefficients));
  return y;
}

bool rivals(const Candidate& a, const Candidate& b) {
  return !a.family.empty() && a.family == "lost motion" && a.family == b.family &&
         a.effect.joint == b.effect.joint;
}

GapFit baseline_fit(const GapFitter& fitter) {
  GapPriors frozen;
  frozen.shift = frozen.bar_scale = 0.0;  // released only with effects in the model: physics-gap.md 8.2
  GapFit fit;
  fit.state = fitter.model().start(fitter.observations());
  return fitter.fit(fit, frozen, false, 4);
}

}  // namespace ballbar

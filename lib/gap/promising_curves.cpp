#include <Eigen/Cholesky>
#include <algorithm>

#include "gap/search.hpp"
#include "gap/search_problem.hpp"

namespace ballbar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::vector<Curve> all_curves(const GapFitter& fitter, const Linearised& at) {
  std::vector<Curve> curves;
  for (int joint = 1; joint <= fitter.model().joints(); ++joint)
    for (const auto& [driver, intervals] : {std::pair{Driver::kAngle, 12},
                                            {Driver::kAngle, 50},
                                            {Driver::kVelocity, 10},
                                            {Driver::kDirection, 12},
                                            {Driver::kTorque, 10}}) {
      Curve curve{joint, driver, 1e300, -1e300, intervals};
      if (driver == Driver::kTorque && !fitter.model().loads_known()) continue;
      double arm = 0.0;
      for (const Tangent& tangent : at.tangents) {
        Drive drive = tangent.drive();
        const VectorXd values = driver_of(curve, tangent, drive);
        curve.from = std::min(curve.from, values.minCoeff());
        curve.to = std::max(curve.to, values.maxCoeff());
        arm = std::max(arm, tangent.joint.col(joint - 1).cwiseAbs().maxCoeff());
      }
      const bool moves =
          driver == Driver::kTorque ? curve.to - curve.from > 0.05 : curve.to - curve.from > 1e-3;
      if (arm > 1e-3 && moves) curves.push_back(curve);
    }
  return curves;
}

}  // namespace

std::vector<Curve> promising_curves(const GapFitter& fitter, const std::vector<Candidate>& candidates,
                                    std::size_t most) {
  const GapPriors priors;
  const GapFit fit = baseline_fit(fitter);
  const Linearised at = fitter.linearise(fit, false);
  const Columns columns =
      all_columns(fitter, at, candidates, std::vector<VectorXd>(candidates.size()), Slope::kChord);
  const Nuisances nuisances = nuisances_of(fitter, at, priors);
  const std::vector<Curve> curves = all_curves(fitter, at);
  MatrixXd all(fitter.rows(), columns.all.cols());
  all = columns.all;
  std::vector<int> widths = columns.widths;
  for (const Curve& curve : curves) {
    const Index begin = all.cols();
    all.conservativeResize(Eigen::NoChange, begin + curve.width());
    for (std::size_t i = 0; i < at.tangents.size(); ++i) {
      const Tangent& tangent = at.tangents[i];
      Drive drive = tangent.drive();
      all.block(at.begin[i], begin, fitter.observations()[i].measured.size(), curve.width()) =
          fitter.whitened(i, curve_columns(curve, tangent, drive));
    }
    widths.push_back(static_cast<int>(curve.width()));
  }
  const EvidenceProblem problem =
      eliminate_baseline(about_zero(fitter, at, fit), nuisances.columns, nuisances.sd, all, widths);
  const Index catalogue = columns.all.cols();
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    // The curve is integrated out as the baseline was; what is left is a search in the catalogue.
    const Index begin = problem.begin[candidates.size() + c], width = curves[c].width();
    MatrixXd a = problem.gram.block(begin, begin, width, width) + MatrixXd::Identity(width, width);
    const Eigen::LLT<MatrixXd> factor(a);
    const MatrixXd half = factor.matrixL().solve(problem.gram.block(begin, 0, width, catalogue));
    const VectorXd part = factor.matrixL().solve(problem.projection.segment(begin, width));
    EvidenceProblem beside;
    beside.gram = problem.gram.topLeftCorner(catalogue, catalogue) - half.transpose() * half;
    beside.projection = problem.projection.head(catalogue) - half.transpose() * part;
    beside.raw_energy = problem.raw_energy.head(catalogue);
    beside.begin.assign(problem.begin.begin(),
                        problem.begin.begin() + static_cast<std::ptrdiff_t>(candidates.size()) + 1);
    const double own = 0.5 * part.squaredNorm() - factor.matrixLLT().diagonal().array().log().sum();
    EvidenceOptions options;
    options.max_groups = 2;
    ranked.emplace_back(-(own + search_evidence(beside, options).best().log_odds), c);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<Curve> best;
  for (std::size_t i = 0; i < std::min(most, ranked.size()); ++i) best.push_back(curves[ranked[i].second]);
  return best;
}

}  // namespace ballbar

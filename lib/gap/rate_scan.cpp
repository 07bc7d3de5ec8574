#include "gap/rate_scan.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastRate = 8.0, kMostRate = 400.0;  // cycles per turn
constexpr double kFinest = 0.8 * std::numbers::pi;     // [rad] of ripple from one place to the next
constexpr double kLeastStrokes = 2.0;                  // cycles within the stroke of the joint
constexpr double kPerResolution = 4.0;                 // rates tried in 2 pi / stroke
constexpr double kRateAboveNoise = 15.0;  // half the drop of chi-squared, beyond what so many tries give

struct RateScan {
  const GapFitter& fitter;
  const Linearised& at;
  const VectorXd& left;  // whitened
  int joint = 0;

  /// Drop of chi-squared with a ripple of each rate.
  VectorXd power(const VectorXd& rates) const {
    std::vector<Eigen::Matrix2d> normal(static_cast<std::size_t>(rates.size()), Eigen::Matrix2d::Zero());
    Eigen::Matrix2Xd by = Eigen::Matrix2Xd::Zero(2, rates.size());
    for (std::size_t i = 0; i < at.tangents.size(); ++i) {
      const Tangent& tangent = at.tangents[i];
      const Index n = tangent.time.size();
      const Eigen::ArrayXd q = tangent.motor.q.row(joint - 1)(tangent.sample).transpose();
      const Eigen::ArrayXd arm = tangent.joint.col(joint - 1);
      MatrixXd both(n, 2 * rates.size());
      for (Index r = 0; r < rates.size(); ++r) {
        both.col(2 * r) = (rates[r] * q).sin() * arm;
        both.col(2 * r + 1) = (rates[r] * q).cos() * arm;
      }
      const MatrixXd white = fitter.whitened(i, both);
      for (Index r = 0; r < rates.size(); ++r) {
        const auto pair = white.middleCols(2 * r, 2);
        normal[static_cast<std::size_t>(r)] += pair.transpose() * pair;
        by.col(r) += pair.transpose() * left.segment(at.begin[i], white.rows());
      }
    }
    VectorXd power(rates.size());
    for (Index r = 0; r < rates.size(); ++r) {
      const Eigen::Matrix2d& each = normal[static_cast<std::size_t>(r)];
      const bool seen = each.determinant() > 1e-9 * each.squaredNorm();
      power[r] = seen ? by.col(r).dot(each.llt().solve(by.col(r))) : 0.0;
    }
    return power;
  }
};

struct RateRange {
  double from = 0.0, to = 0.0, step = 0.0;
};

std::optional<RateRange> rates_for(const Linearised& at, int joint) {
  double least = 1e300, most = -1e300, fastest = 0.0;
  // Stops lie far apart, but at each the angle is exact: they limit the rate only where nothing else does.
  const bool all_at_rest =
      std::all_of(at.tangents.begin(), at.tangents.end(), [](const Tangent& one) { return one.at_rest; });
  for (const Tangent& tangent : at.tangents) {
    const Eigen::RowVectorXd q = tangent.motor.q.row(joint - 1)(tangent.sample);
    least = std::min(least, q.minCoeff());
    most = std::max(most, q.maxCoeff());
    if (q.size() > 1 && (all_at_rest || !tangent.at_rest))
      fastest = std::max(fastest, (q.tail(q.size() - 1) - q.head(q.size() - 1)).cwiseAbs().maxCoeff());
  }
  if (!(most > least) || !(fastest > 0.0)) return {};
  const double resolution = 2.0 * std::numbers::pi / (most - least);
  const RateRange range{std::max(kLeastRate, kLeastStrokes * resolution),
                        std::min(kMostRate, kFinest / fastest), resolution / kPerResolution};
  if (!(range.to > range.from)) return {};
  return range;
}

/// The top of the peak about `rate`, as a candidate; nothing where there is none within the step.
std::optional<Candidate> top_of(const RateScan& scan, double rate, double step) {
  constexpr int kRefined = 8;
  for (int round = 0; round < kRefined; ++round, step /= 2.0) {
    const VectorXd near = rate + step * VectorXd::LinSpaced(5, -1.0, 1.0).array();
    Index best = 0;
    scan.power(near).maxCoeff(&best);
    rate = near[best];
  }
  const double apart = 32.0 * step;
  const VectorXd power = scan.power(rate + apart * VectorXd::LinSpaced(3, -1.0, 1.0).array());
  const double bend = (2.0 * power[1] - power[0] - power[2]) / (apart * apart);
  if (!(bend > 0.0)) return {};
  Candidate candidate = ripple(scan.joint, rate);
  candidate.rate_sd = std::sqrt(2.0 / bend);
  return candidate;
}

}  // namespace

bool add_ripples_of_unknown_rate(const GapFitter& fitter, const GapFit& fit,
                                 std::vector<Candidate>& candidates) {
  const Linearised at = fitter.linearise(fit, true);
  VectorXd left = at.residual;
  if (fit.shape.size() == at.shape.cols()) left -= at.shape * fit.shape;
  const std::vector<double>& ratio = fitter.model().spec().gear_ratio;
  bool changed = false;
  for (int joint = 1; joint <= fitter.model().joints(); ++joint) {
    const auto index = static_cast<std::size_t>(joint - 1);
    if (index < ratio.size() && ratio[index] > 0.0) continue;
    const std::optional<RateRange> range = rates_for(at, joint);
    if (!range) continue;
    const auto of_scan = [&](const Candidate& one) { return one.rate_sd > 0.0 && one.effect.joint == joint; };
    const auto known = std::find_if(candidates.begin(), candidates.end(), of_scan);
    const auto named = std::find_if(fit.named.begin(), fit.named.end(),
                                    [&](const NamedEffect& one) { return of_scan(one.candidate); });
    if (named != fit.named.end()) {  // again, now that the others are known
      const VectorXd whole = left + fitter.contribution(at, named->candidate.with(named->coefficients));
      const double rate = named->candidate.effect.values[0];
      const std::optional<Candidate> top = top_of({fitter, at, whole, joint}, rate, range->step);
      if (!top || std::abs(top->effect.values[0] - rate) < top->rate_sd) continue;
      *known = *top;
      changed = true;
      continue;
    }
    if (known != candidates.end()) continue;  // it was weighed, and found to be something else
    const RateScan scan{fitter, at, left, joint};
    const auto tries = static_cast<Index>((range->to - range->from) / range->step) + 1;
    Index best = 0;
    const double highest = scan.power(VectorXd::LinSpaced(tries, range->from, range->to)).maxCoeff(&best);
    if (!(0.5 * highest > kRateAboveNoise + std::log(static_cast<double>(tries)))) continue;
    const double rate = tries > 1 ? range->from + static_cast<double>(best) * (range->to - range->from) /
                                                      static_cast<double>(tries - 1)
                                  : range->from;
    const std::optional<Candidate> top = top_of(scan, rate, range->step);
    if (!top) continue;
    candidates.push_back(*top);
    changed = true;
  }
  return changed;
}

}  // namespace ballbar

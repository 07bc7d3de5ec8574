#include "gap/pose_scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ballbar {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double kStepsPerResolution = 5.0;
constexpr double kLeastCycles = 1.5;   // below it: eccentricity and geometry
constexpr double kLeastStroke = 0.02;  // [rad] a joint that stands still has no phase
constexpr double kLeastPower = 4.0;
constexpr double kRowsBesideJump = 5.0;  // fewer are outliers

/// Power at each rate of an even grid, by turning each row's phasor on.
class Scan {
 public:
  Scan(const ArrayXd& q, ArrayXd projected, ArrayXd weight, double sd)
      : q_(q), projected_(std::move(projected)), weight_(std::move(weight)), variance_(sd * sd) {}

  VectorXd powers(double first, double step, Index count) const {
    ArrayXd c = (first * q_).cos(), s = (first * q_).sin();
    const ArrayXd dc = (step * q_).cos(), ds = (step * q_).sin();
    VectorXd powers(count);
    for (Index k = 0; k < count; ++k) {
      powers[k] = power(c, s);
      const ArrayXd next = c * dc - s * ds;
      s = s * dc + c * ds;
      c = next;
    }
    return powers;
  }

  double power_at(double cycles) const { return power((cycles * q_).cos(), (cycles * q_).sin()); }

 private:
  double power(const ArrayXd& c, const ArrayXd& s) const {
    const double pc = (projected_ * c).sum(), ps = (projected_ * s).sum();
    const double cc = (weight_ * c.square()).sum(), cs = (weight_ * c * s).sum();
    const double ss = weight_.sum() - cc, det = cc * ss - cs * cs;
    if (!(det > 1e-6 * cc * ss)) return 0.0;
    return 0.5 * (pc * pc * ss - 2.0 * pc * ps * cs + ps * ps * cc) / (det * variance_);
  }

  ArrayXd q_, projected_, weight_;
  double variance_;
};

/// The top of a peak, by golden sections between its neighbours on the grid.
double refined(const Scan& scan, double left, double right) {
  constexpr double kGolden = 0.6180339887498949;
  for (int i = 0; i < 12; ++i) {
    const double a = right - kGolden * (right - left), b = left + kGolden * (right - left);
    if (scan.power_at(a) < scan.power_at(b))
      left = a;
    else
      right = b;
  }
  return 0.5 * (left + right);
}

std::vector<PosePeak> peaks_of(const Scan& scan, int joint, double stroke, double most_cycles, int most) {
  const double resolution = 2.0 * std::numbers::pi / stroke, step = resolution / kStepsPerResolution;
  const double first = std::max(kLeastCycles, resolution);
  std::vector<PosePeak> peaks;
  if (first >= most_cycles) return peaks;
  const auto count = static_cast<Index>((most_cycles - first) / step) + 1;
  const VectorXd powers = scan.powers(first, step, count);
  for (Index k = 0; k < count; ++k) {
    const bool top = (k == 0 || powers[k] >= powers[k - 1]) && (k + 1 == count || powers[k] > powers[k + 1]);
    if (top && powers[k] > kLeastPower)
      peaks.push_back({joint, first + step * static_cast<double>(k), powers[k],
                       static_cast<double>(count) / kStepsPerResolution, stroke});
  }
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const PosePeak& a, const PosePeak& b) { return a.power > b.power; });
  std::vector<PosePeak> kept;
  for (PosePeak& peak : peaks) {
    if (static_cast<int>(kept.size()) == most) break;
    const bool side = std::any_of(kept.begin(), kept.end(), [&](const PosePeak& k) {
      return std::abs(k.setting - peak.setting) < 0.8 * resolution;  // a lobe of one that is there
    });
    if (side) continue;
    peak.setting = refined(scan, peak.setting - step, peak.setting + step);
    kept.push_back(peak);
  }
  return kept;
}

}  // namespace

std::vector<PosePeak> scan_ripples(const std::vector<PoseRow>& rows,
                                   const std::vector<PoseGeometry>& geometry, const VectorXd& residual,
                                   int per_row, double sd, double most_cycles, int most) {
  std::vector<PosePeak> all;
  const auto n = static_cast<Index>(rows.size());
  for (Index j = 0; n > 0 && j < rows.front().q.size(); ++j) {
    ArrayXd q(n), projected(n), weight(n);
    for (Index i = 0; i < n; ++i) {
      const auto column = geometry[static_cast<std::size_t>(i)].columns.joint.col(j).head(per_row);
      q[i] = rows[static_cast<std::size_t>(i)].q[j];
      projected[i] = column.dot(residual.segment(per_row * i, per_row));
      weight[i] = column.squaredNorm();
    }
    const double stroke = q.maxCoeff() - q.minCoeff();
    if (stroke < kLeastStroke) continue;
    const Scan scan(q, std::move(projected), std::move(weight), sd);
    for (const PosePeak& peak : peaks_of(scan, static_cast<int>(j) + 1, stroke, most_cycles, most))
      all.push_back(peak);
  }
  return all;
}

std::vector<PosePeak> scan_jumps(const std::vector<PoseRow>& rows, const VectorXd& residual, int per_row,
                                 double sd) {
  std::vector<PosePeak> all;
  int frames = 0;
  for (const PoseRow& row : rows) frames = std::max(frames, row.frame + 1);
  for (int frame = 0; frame < frames; ++frame) {
    std::vector<Index> inside;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (rows[i].frame == frame) inside.push_back(static_cast<Index>(i));
    PosePeak best{0, 0.0, 0.0, static_cast<double>(inside.size())};
    VectorXd sum = VectorXd::Zero(per_row), total = VectorXd::Zero(per_row);
    for (const Index i : inside) total += residual.segment(per_row * i, per_row);
    const auto n = static_cast<double>(inside.size());
    for (std::size_t k = 1; k < inside.size(); ++k) {
      sum += residual.segment(per_row * inside[k - 1], per_row);
      const auto before = static_cast<double>(k);
      if (before < kRowsBesideJump || n - before < kRowsBesideJump) continue;
      const double power =
          0.5 * (sum - before / n * total).squaredNorm() / (before * (n - before) / n * sd * sd);
      if (power > best.power) {
        best.power = power;
        best.setting = rows[static_cast<std::size_t>(inside[k])].row;
      }
    }
    if (best.power > kLeastPower) all.push_back(best);
  }
  return all;
}

}  // namespace ballbar

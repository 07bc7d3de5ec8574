#include "metrology/volumetric.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "metrology/arc.hpp"
#include "metrology/signature_columns.hpp"
#include "numerics/resolved_fit.hpp"

namespace ballbar {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kEnoughOfTrace = 720;  // samples of a trace: shapes of order 2 need no more
constexpr Index kErrors = 6;
constexpr Index kOwn = 7;  // columns of a plane: the ball's place, and what the direction turns

/// Traces of one test.
struct Plane {
  std::string test;
  CircleSpec spec;
  std::vector<CircleTrace> traces;

  Index repetitions(int direction) const {
    return std::count_if(traces.begin(), traces.end(),
                         [&](const CircleTrace& trace) { return trace.direction == direction; });
  }
};

/// Those that were driven both ways.
std::vector<Plane> planes_of(const std::vector<PlaneTrace>& traces) {
  std::vector<Plane> planes;
  for (const PlaneTrace& each : traces) {
    if (std::abs(each.trace.direction) != 1)
      throw std::invalid_argument("volumetric: a direction is not +1 or -1");
    if (!carries_centre(each.trace.angle)) continue;
    const auto same = [&](const Plane& plane) {
      return plane.test == each.test && plane.spec.normal == each.spec.normal &&
             plane.spec.first_axis == each.spec.first_axis && plane.spec.radius == each.spec.radius;
    };
    auto found = std::find_if(planes.begin(), planes.end(), same);
    if (found == planes.end()) found = planes.insert(planes.end(), {each.test, each.spec, {}});
    found->traces.push_back(signature::thinned(each.trace, kEnoughOfTrace));
  }
  std::erase_if(planes, [](const Plane& p) { return p.repetitions(1) == 0 || p.repetitions(-1) == 0; });
  return planes;
}

/// Columns of the six errors, per unit of each.
MatrixXd error_columns(const ArrayXd& angle, const CircleSpec& spec) {
  const CirclePlane plane = plane_of(spec);
  const Matrix3Xd u =
      plane.e1 * angle.cos().matrix().transpose() + plane.e2 * angle.sin().matrix().transpose();
  MatrixXd columns(angle.size(), kErrors);
  for (Index k = 0; k < 3; ++k) {
    const Index next = (k + 1) % 3;
    columns.col(k) = spec.radius * u.row(k).cwiseProduct(u.row(k)).transpose();
    columns.col(3 + k) = -spec.radius * u.row(k).cwiseProduct(u.row(next)).transpose();
  }
  return columns;
}

MatrixXd own_columns(const ArrayXd& angle, double way) {
  MatrixXd columns(angle.size(), kOwn);
  columns << angle.cos().matrix(), angle.sin().matrix(), VectorXd::Constant(angle.size(), way),
      way * angle.cos().matrix(), way * angle.sin().matrix(), way * (2.0 * angle).cos().matrix(),
      way * (2.0 * angle).sin().matrix();
  return columns;
}

struct Problem {
  MatrixXd columns;
  VectorXd value;
  VectorXd weight;  ///< of all repetitions of a way and plane together as much as of one
};

Problem problem_of(const std::vector<Plane>& planes) {
  Index rows = 0;
  for (const Plane& plane : planes)
    for (const CircleTrace& trace : plane.traces) rows += trace.angle.size();
  const auto own = kOwn * static_cast<Index>(planes.size());
  Problem problem{MatrixXd::Zero(rows, kErrors + own), VectorXd(rows), VectorXd(rows)};
  Index at = 0;
  Index first = kErrors;
  for (const Plane& plane : planes) {
    const std::vector<VectorXd> motion = motion_deviations(plane.traces, plane.spec.radius);
    for (std::size_t k = 0; k < plane.traces.size(); ++k) {
      const CircleTrace& trace = plane.traces[k];
      const Index count = trace.angle.size();
      problem.columns.block(at, 0, count, kErrors) = error_columns(trace.angle.array(), plane.spec);
      problem.columns.block(at, first, count, kOwn) = own_columns(trace.angle.array(), trace.direction);
      problem.value.segment(at, count) = motion[k];
      problem.weight.segment(at, count).setConstant(1.0 /
                                                    static_cast<double>(plane.repetitions(trace.direction)));
      at += count;
    }
    first += kOwn;
  }
  return problem;
}

}  // namespace

std::optional<Volumetric> analyse_volumetric(const std::vector<PlaneTrace>& traces) {
  const std::vector<Plane> planes = planes_of(traces);
  if (planes.empty()) return std::nullopt;
  const Problem problem = problem_of(planes);
  if (problem.columns.rows() <= problem.columns.cols()) return std::nullopt;
  const ResolvedFit fit = fit_resolved(problem.columns, problem.value, problem.weight);
  for (int k = 0; k < kErrors; ++k)
    if (!fit.told_apart(k)) return std::nullopt;
  // The fit counts rows: weights that sum to fewer give the residual's variance too small by that share.
  const double widened = static_cast<double>(problem.weight.size()) / problem.weight.sum();
  const auto estimate = [&](Index k) {
    return Estimate{fit.coefficients[k], std::sqrt(widened * fit.covariance(k, k))};
  };
  Volumetric found;
  for (std::size_t k = 0; k < 3; ++k) {
    found.scaling[k] = estimate(static_cast<Index>(k));
    found.squareness[k] = estimate(static_cast<Index>(3 + k));
  }
  found.residual = std::sqrt(fit.residual.squaredNorm() / static_cast<double>(fit.residual.size()));
  return found;
}

std::optional<CircleSpec> plane_named(const std::string& name, double radius) {
  CircleSpec spec;
  spec.radius = radius;
  for (std::size_t n = 0; n < 3; ++n)
    for (std::size_t f = 0; f < 3; ++f)
      for (const int signs : {0, 1, 2, 3}) {
        if (n == f) continue;
        spec.normal = {};
        spec.first_axis = {};
        spec.normal[n] = (signs & 1) != 0 ? -1.0 : 1.0;
        spec.first_axis[f] = (signs & 2) != 0 ? -1.0 : 1.0;
        if (plane_name(spec) == name) return spec;
      }
  return std::nullopt;
}

}  // namespace ballbar

#include "metrology/arc.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "core/units.hpp"
#include "numerics/vector3.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
constexpr double kFeedTolerance = 0.1;  // of the duration
constexpr double kHoleSteps = 5.0;
constexpr double kEdgeSteps = 0.01;

/// Coverage and largest hole of the angles found on the arc.
void measure_coverage(std::vector<double> found, const CircleSpec& spec, Arc& arc) {
  arc.largest_hole = spec.arc_sweep;
  if (found.empty()) return;
  std::sort(found.begin(), found.end());
  std::vector<double> steps;
  for (std::size_t i = 1; i < found.size(); ++i) steps.push_back(found[i] - found[i - 1]);
  double usual = 0.0;
  if (!steps.empty()) {
    std::vector<double> ordered = steps;
    const auto middle = ordered.begin() + static_cast<std::ptrdiff_t>(ordered.size() / 2);
    std::nth_element(ordered.begin(), middle, ordered.end());
    usual = *middle;
  }
  steps.push_back(found.front() - spec.arc_start);
  steps.push_back(spec.arc_start + spec.arc_sweep - found.back());
  arc.largest_hole = *std::max_element(steps.begin(), steps.end());
  const double widest_step = std::max(kHoleSteps * usual, spec.arc_sweep / 360.0);
  double holes = 0.0;
  for (const double step : steps)
    if (step > widest_step) holes += step;
  arc.coverage = std::clamp(1.0 - holes / spec.arc_sweep, 0.0, 1.0);
}

/// "X", "-Z", or "(0.6, 0, 0.8)".
std::string axis_name(const Vector3d& direction) {
  constexpr double kAlong = 1e-6;
  for (const Index k : {0, 1, 2}) {
    const Vector3d axis = Vector3d::Unit(k);
    if ((direction - axis).norm() < kAlong) return std::string(1, "XYZ"[k]);
    if ((direction + axis).norm() < kAlong) return std::string("-") + "XYZ"[k];
  }
  std::ostringstream text;
  text.imbue(std::locale::classic());
  for (const Index k : {0, 1, 2}) text << (k == 0 ? "(" : ", ") << std::round(direction[k] * 1e3) / 1e3 + 0.0;
  return text.str() + ")";
}

}  // namespace

CirclePlane plane_of(const CircleSpec& spec) {
  CirclePlane plane;
  plane.centre = vector_of(spec.centre);
  plane.normal = vector_of(spec.normal).normalized();
  const Vector3d first = vector_of(spec.first_axis);
  const Vector3d across = first - first.dot(plane.normal) * plane.normal;
  if (!(plane.normal.norm() > 0.5) || !(across.norm() > 1e-9))
    throw std::invalid_argument("circle: normal and first_axis span no plane");
  plane.e1 = across.normalized();
  plane.e2 = plane.normal.cross(plane.e1);
  return plane;
}

std::string plane_name(const CircleSpec& spec) {
  const CirclePlane plane = plane_of(spec);
  const std::string normal = axis_name(plane.normal);
  const std::string first = axis_name(plane.e1);
  std::string name = normal.back() == 'X' ? "YZ" : normal.back() == 'Y' ? "ZX" : "XY";
  if (normal.size() == 1 && first == name.substr(0, 1)) return name;
  return (normal.size() <= 2 ? name + ", " : "") + "normal " + normal + ", angle 0 on " + first;
}

VectorXd angles_on_circle(const Eigen::Matrix3Xd& points, const CircleSpec& spec) {
  const CirclePlane plane = plane_of(spec);
  VectorXd angle(points.cols());
  double before = kNotKnown;
  for (Index i = 0; i < points.cols(); ++i) {
    const Vector3d arm = points.col(i) - plane.centre;
    if (!arm.allFinite()) {
      angle[i] = kNotKnown;
      continue;
    }
    angle[i] = std::atan2(arm.dot(plane.e2), arm.dot(plane.e1));
    if (std::isfinite(before)) angle[i] += kTurn * std::round((before - angle[i]) / kTurn);
    before = angle[i];
  }
  return angle;
}

VectorXd angles_at_constant_feed(const VectorXd& time, double begin, double end, const CircleSpec& spec,
                                 int direction, double feed) {
  const double duration = end - begin;
  if (direction == 0 || !(duration > 0.0)) return VectorXd::Constant(time.size(), kNotKnown);
  const double driven = spec.arc_sweep + 2.0 * spec.overshoot;
  double rate = feed / spec.radius;
  const bool feed_fits = rate > 0.0 && std::abs(driven / rate - duration) <= kFeedTolerance * duration;
  if (!feed_fits) rate = driven / duration;
  const double signed_rate = direction > 0 ? rate : -rate;
  return spec.arc_start + spec.arc_sweep / 2.0 + signed_rate * (time.array() - (begin + end) / 2.0);
}

std::optional<double> calculated_feed(const VectorXd& angle, const VectorXd& time, double radius) {
  if (angle.size() != time.size()) throw std::invalid_argument("feed: angles and times differ in number");
  Index first = 0;
  Index last = angle.size() - 1;
  while (first <= last && !std::isfinite(angle[first])) ++first;
  while (last > first && !std::isfinite(angle[last])) --last;
  if (last <= first || !(time[last] > time[first])) return std::nullopt;
  return radius * std::abs(angle[last] - angle[first]) / (time[last] - time[first]);
}

Arc find_arc(Eigen::Ref<VectorXd> angle, const CircleSpec& spec) {
  Arc arc;
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  int known = 0;
  for (const double a : angle) {
    if (!std::isfinite(a)) continue;
    ++known;
    least = std::min(least, a);
    most = std::max(most, a);
  }
  if (least <= most) {
    const double middle_of_arc = spec.arc_start + spec.arc_sweep / 2.0;
    angle.array() += kTurn * std::round((middle_of_arc - (least + most) / 2.0) / kTurn);
  }
  // Where samples fall on the ends themselves, microseconds of rounding must not decide whether one more or
  // less is taken: it would move the least-squares centre of an oval trace by a tenth of a micrometre.
  const double edge = known > 1 ? kEdgeSteps * (most - least) / (known - 1) : 0.0;
  const double first = spec.arc_start - edge;
  std::vector<double> found;
  for (Index i = 0; i < angle.size(); ++i) {
    if (!(angle[i] >= first && angle[i] < first + spec.arc_sweep)) continue;
    if (found.empty()) arc.begin = static_cast<std::size_t>(i);
    arc.end = static_cast<std::size_t>(i) + 1;
    found.push_back(angle[i]);
  }
  measure_coverage(std::move(found), spec, arc);
  return arc;
}

}  // namespace ballbar

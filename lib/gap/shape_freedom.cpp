#include "gap/shape_freedom.hpp"

#include <cmath>

#include "gap/gap_fit.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLinkMass = 0.10;         // of the masses from the second joint's link on
constexpr double kHandMass = 0.30;         // of those behind the wrist
constexpr double kComShift = 0.010;        // [m]
constexpr double kHardening = 0.15;        // of the stiffness
constexpr double kHardeningTorque = 10.0;  // [Nm]
constexpr double kRippleOvertone = 0.15;
constexpr double kTurnOvertone = 0.07;

/// Deflections of a joint by torques of other masses: 3 groups of mass, 2 of centres.
constexpr Index kComplianceColumns = 6;

bool is(const NamedEffect& named, const char* name) { return named.candidate.effect.kind->name == name; }

/// The torque's change where masses are wrong: upper arm, forearm, wrist; centres of upper arm and forearm
/// along their link.
void add_compliance(const Tangent& at, const Effect& effect, Eigen::Ref<MatrixXd> columns) {
  const Index joint = effect.joint - 1;
  const double size = effect.values[0];
  const auto on_joint = [&](const MatrixXd& torque) -> VectorXd { return torque.row(joint)(at.sample); };
  const auto group_of = [](const Body& body) { return body.joint <= 2 ? 0 : body.joint <= 4 ? 1 : 2; };
  const VectorXd nominal = on_joint(at.loads->torque());
  Index next = 0;
  for (int group = 0; group < 3; ++group) {
    const auto heavier = [&](std::vector<Body> bodies) {
      for (Body& body : bodies) {
        if (body.name == "payload" || group_of(body) != group) continue;
        const double more = 1.0 + (group == 2 ? kHandMass : kLinkMass);
        body.mass *= more;
        body.inertia *= more;
      }
      return bodies;
    };
    columns.col(next) = -size * (on_joint(at.loads->torque(static_cast<int>(next), heavier)) - nominal)
                                    .cwiseProduct(at.joint.col(joint));
    ++next;
  }
  for (int group = 0; group < 2; ++group) {
    const auto moved = [&](std::vector<Body> bodies) {
      for (Body& body : bodies)
        if (body.name != "payload" && group_of(body) == group) body.com.x() += kComShift;
      return bodies;
    };
    columns.col(next) = -size * (on_joint(at.loads->torque(static_cast<int>(next), moved)) - nominal)
                                    .cwiseProduct(at.joint.col(joint));
    ++next;
  }
  const Eigen::ArrayXd t = nominal.array();
  columns.col(next) = -size * kHardening *
                      (t * ((t / kHardeningTorque).square() / (1.0 + (t / kHardeningTorque).square())))
                          .matrix()
                          .cwiseProduct(at.joint.col(joint));
}

/// Twice the cycles, both phases.
void add_overtone(const Tangent& at, const Effect& effect, double cycles, double amplitude,
                  Eigen::Ref<MatrixXd> columns) {
  const Index joint = effect.joint - 1;
  const Eigen::ArrayXd q = at.motor.q.row(joint)(at.sample).transpose().array();
  columns.col(0) = amplitude * (2.0 * cycles * q).sin().matrix().cwiseProduct(at.joint.col(joint));
  columns.col(1) = amplitude * (2.0 * cycles * q).cos().matrix().cwiseProduct(at.joint.col(joint));
}

}  // namespace

Index shape_width(const NamedEffect& named) {
  if (is(named, "joint_compliance")) return kComplianceColumns;
  if (is(named, "transmission_error") || is(named, "joint_eccentricity")) return 2;
  return 0;
}

Index shape_width(const GapFit& fit) {
  Index width = fit.curve ? fit.curve->width() : 0;
  for (const NamedEffect& one : fit.named) width += shape_width(one);
  return width;
}

MatrixXd shape_columns(const Tangent& at, const GapFit& fit) {
  MatrixXd all(at.time.size(), shape_width(fit));
  Drive drive = at.drive();
  Index next = 0;
  for (const NamedEffect& one : fit.named) {
    const Index width = shape_width(one);
    if (width == 0) continue;
    const Effect effect = one.candidate.with(one.coefficients);
    auto columns = all.middleCols(next, width);
    if (is(one, "joint_compliance")) {
      add_compliance(at, effect, columns);
    } else if (is(one, "transmission_error")) {
      add_overtone(at, effect, effect.values[0], kRippleOvertone * effect.values[1], columns);
    } else {
      add_overtone(at, effect, 1.0, kTurnOvertone * effect.values[0], columns);
    }
    next += width;
  }
  if (fit.curve) all.rightCols(fit.curve->width()) = curve_columns(*fit.curve, at, drive);
  return all;
}

}  // namespace ballbar

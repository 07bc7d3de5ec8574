#include "arm.hpp"

#include <cmath>
#include <stdexcept>

namespace blind {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;

// Row i: Rx(alpha) Tx(a) Ry(beta) Rz(theta) Tz(d).
constexpr Joints kAlpha = {0.0, -90.0 * kRad, 0.0, -90.0 * kRad, 90.0 * kRad, -90.0 * kRad};
constexpr Joints kA = {0.0, 0.075, 0.300, 0.075, 0.0, 0.0};
constexpr Joints kD = {0.0, 0.0, 0.0, 0.320, 0.0, 0.080};
constexpr Joints kTheta = {0.0, -90.0 * kRad, 0.0, 0.0, 0.0, 0.0};
constexpr Joints kTurn = {1.0, 1.0, -1.0, -1.0, -1.0, -1.0};  // the chain turns joints 3 to 6 about -z
constexpr double kTool = 0.07465;
constexpr double kGravity = 9.80665;

Matrix4d rotation_x(double angle) {
  Matrix4d m = Matrix4d::Identity();
  m(1, 1) = m(2, 2) = std::cos(angle);
  m(2, 1) = std::sin(angle);
  m(1, 2) = -m(2, 1);
  return m;
}

Matrix4d rotation_y(double angle) {
  Matrix4d m = Matrix4d::Identity();
  m(0, 0) = m(2, 2) = std::cos(angle);
  m(0, 2) = std::sin(angle);
  m(2, 0) = -m(0, 2);
  return m;
}

Matrix4d rotation_z(double angle) {
  Matrix4d m = Matrix4d::Identity();
  m(0, 0) = m(1, 1) = std::cos(angle);
  m(1, 0) = std::sin(angle);
  m(0, 1) = -m(1, 0);
  return m;
}

Matrix4d translation(double x, double y, double z) {
  Matrix4d m = Matrix4d::Identity();
  m(0, 3) = x;
  m(1, 3) = y;
  m(2, 3) = z;
  return m;
}

Matrix4d row(std::size_t i, double q, const Deviations& off) {
  Matrix4d m = rotation_x(kAlpha[i] + off.alpha[i]) * translation(kA[i] + off.a[i], 0.0, 0.0);
  if (off.beta[i] != 0.0) m *= rotation_y(off.beta[i]);
  return m * rotation_z(kTheta[i] + kTurn[i] * q) * translation(0.0, 0.0, kD[i] + off.d[i]);
}

struct Body {
  std::size_t frame;  // moves with this joint
  Vector3d place;     // in the frame of that row
  double kg;
};

std::vector<Body> bodies(double payload_kg, const Masses& by) {
  // Frame 2: x along the upper arm. Frame 3: x up, y forward. Frame 4: z forward, its origin at the wrist's
  // centre.
  return {{1, {0.150 + by.upper_arm_off, 0.0, 0.0}, 5.5 * by.upper_arm},
          {2, {0.060, 0.080 + by.forearm_off, 0.0}, 6.0 * by.forearm},
          {4, {0.0, 0.030, 0.0}, 1.2 * by.wrist},
          {5, {0.0, 0.0, 0.050 + by.payload_off}, payload_kg}};
}

}  // namespace

Vector3d tool_point(const Joints& q, const Deviations& off) {
  Matrix4d m = row(0, q[0], off);
  for (std::size_t i = 1; i < 6; ++i) m *= row(i, q[i], off);
  return (m * (Vector3d(0.0, 0.0, kTool) + off.tool).homogeneous()).head<3>();
}

Joints inverse(const Vector3d& point, const Matrix3d& tool, const Joints& near) {
  const Vector3d wrist = point - (kD[5] + kTool) * tool.col(2);
  Joints q{};
  q[0] = std::atan2(wrist.y(), wrist.x());
  const double out = std::hypot(wrist.x(), wrist.y()) - kA[1], up = wrist.z();
  const double fore = std::hypot(kD[3], kA[3]), reach = std::hypot(out, up);
  const double bend = (kA[2] * kA[2] + reach * reach - fore * fore) / (2.0 * kA[2] * reach);
  if (!(bend < 1.0)) throw std::domain_error("out of reach");
  q[1] = std::atan2(out, up) - std::acos(bend);
  const double x = out - kA[2] * std::sin(q[1]), z = up - kA[2] * std::cos(q[1]);
  // The forearm leans by q1 - q2 from level; at 0 its way to the wrist is (d4, a4).
  const double lean = std::atan2(kA[3], kD[3]) - std::atan2(z, x);
  q[2] = q[1] - lean;

  const Deviations none;
  Matrix4d arm = row(0, q[0], none);
  for (std::size_t i = 1; i < 3; ++i) arm *= row(i, q[i], none);
  // Frame 3 to tool: Rx(-90) Rz(t4) Rx(90) Rz(t5) Rx(-90) Rz(t6); its third column is (-c4 s5, c5, s4 s5).
  const Matrix3d rest = arm.topLeftCorner<3, 3>().transpose() * tool;
  const double t5 = std::acos(std::clamp(rest(1, 2), -1.0, 1.0));
  if (t5 < 2.0 * kRad) throw std::domain_error("wrist singular");
  const double t4 = std::atan2(rest(2, 2), -rest(0, 2));
  const double t6 = std::atan2(-rest(1, 1), rest(1, 0));
  q[4] = -t5;
  for (const auto& [i, t] : {std::pair{3, t4}, std::pair{5, t6}}) {
    const auto at = static_cast<std::size_t>(i);
    q[at] = -t + 2.0 * std::numbers::pi * std::round((near[at] + t) / (2.0 * std::numbers::pi));
  }
  return q;
}

std::vector<Joints> torques(const std::vector<Joints>& q, double step, double payload_kg,
                            const Masses& masses) {
  const std::vector<Body> all = bodies(payload_kg, masses);
  const Deviations none;
  struct Pose {
    std::array<Vector3d, 6> origin, axis;
    std::vector<Vector3d> place;
  };
  const auto pose = [&](const Joints& at) {
    Pose p;
    Matrix4d m = Matrix4d::Identity();
    for (std::size_t i = 0; i < 6; ++i) {
      m *= row(i, at[i], none);
      p.origin[i] = m.topRightCorner<3, 1>();
      p.axis[i] = kTurn[i] * m.block<3, 1>(0, 2);
      for (const Body& body : all)
        if (body.frame == i) p.place.emplace_back((m * body.place.homogeneous()).head<3>());
    }
    return p;
  };
  std::vector<Joints> result(q.size());
  if (q.size() < 3) return result;
  std::array<Pose, 3> three = {pose(q[0]), pose(q[1]), pose(q[2])};
  for (std::size_t k = 1; k + 1 < q.size(); ++k) {
    if (k > 1) three = {std::move(three[1]), std::move(three[2]), pose(q[k + 1])};
    const Pose& here = three[1];
    for (std::size_t b = 0; b < all.size(); ++b) {
      const Vector3d acceleration =
          (three[2].place[b] - 2.0 * here.place[b] + three[0].place[b]) / (step * step);
      const Vector3d force = all[b].kg * (acceleration + Vector3d(0.0, 0.0, kGravity));
      for (std::size_t i = 0; i <= all[b].frame; ++i)
        result[k][i] += here.axis[i].dot((here.place[b] - here.origin[i]).cross(force));
    }
  }
  result.front() = result[1];
  result.back() = result[q.size() - 2];
  return result;
}

}  // namespace blind

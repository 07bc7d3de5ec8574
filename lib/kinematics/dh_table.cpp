#include "kinematics/dh_table.hpp"

#include <algorithm>
#include <cmath>

namespace ballbar {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kParallelSine = 0.0872;  // 5 deg: beyond it the common normal is well defined
constexpr double kZeroLength = 1e-7;      // [m] finer than any drawing, coarser than rounding

/// Line 0 is the base's z, line i the axis of joint i.
struct Line {
  Vector3d point, direction;
  Vector3d arrival;    ///< where the way from the former line meets this one
  Vector3d departure;  ///< where the way to the next one starts: origin of this line's frame
  Vector3d x, z;       ///< of this line's frame
};

bool parallel(const Line& a, const Line& b) { return a.direction.cross(b.direction).norm() < kParallelSine; }

/// Whether v points to the side that is called positive where nothing else decides.
bool positive(const Vector3d& v) {
  Eigen::Index largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  return v(largest) > 0.0;
}

void find_feet(std::vector<Line>& lines, const Vector3d& last_origin) {
  lines.front().arrival = lines.front().point;
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    Line& from = lines[i];
    Line& to = lines[i + 1];
    if (parallel(from, to)) {
      from.departure = from.arrival;
      const double way = (from.departure - to.point).dot(from.direction) / to.direction.dot(from.direction);
      to.arrival = to.point + way * to.direction;
    } else {  // the common normal
      const Vector3d between = to.point - from.point;
      const Vector3d normal = from.direction.cross(to.direction);
      const double square = normal.squaredNorm();
      from.departure = from.point + between.cross(to.direction).dot(normal) / square * from.direction;
      to.arrival = to.point + between.cross(from.direction).dot(normal) / square * to.direction;
    }
  }
  Line& last = lines.back();
  last.departure = last.point + (last_origin - last.point).dot(last.direction) * last.direction;
}

void choose_z(std::vector<Line>& lines) {
  lines.front().z = lines.front().direction;
  for (std::size_t begin = 0, end = 0; begin < lines.size(); begin = end) {
    Vector3d z =
        positive(lines[begin].direction) ? lines[begin].direction : Vector3d(-lines[begin].direction);
    bool decided = begin == 0;  // the base's own z is given
    for (end = begin; end < lines.size() && (end == begin || parallel(lines[end - 1], lines[end])); ++end) {
      const double d = (lines[end].departure - lines[end].arrival).dot(z);
      if (!decided && std::abs(d) > kZeroLength) {
        if (d < 0) z = -z;
        decided = true;
      }
    }
    for (std::size_t i = begin; i < end; ++i)
      lines[i].z = lines[i].direction.dot(z) > 0 ? lines[i].direction : Vector3d(-lines[i].direction);
  }
}

void choose_x(std::vector<Line>& lines) {
  Vector3d former = Vector3d::UnitX();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const bool last = i + 1 == lines.size();
    Line& line = lines[i];
    const Vector3d way = last ? Vector3d::Zero().eval() : (lines[i + 1].arrival - line.departure).eval();
    if (way.norm() > kZeroLength) {
      line.x = way.normalized();
    } else if (!last && !parallel(line, lines[i + 1])) {
      line.x = line.z.cross(lines[i + 1].z).normalized();
      const double nearer = line.x.dot(former);
      if (std::abs(nearer) > 1e-6 ? nearer < 0 : !positive(line.x)) line.x = -line.x;
    } else {
      line.x = (former - former.dot(line.z) * line.z).normalized();
    }
    former = line.x;
  }
}

Isometry3d frame_of(const Line& line) {
  Isometry3d frame = Isometry3d::Identity();
  frame.linear().col(0) = line.x;
  frame.linear().col(1) = line.z.cross(line.x);
  frame.linear().col(2) = line.z;
  frame.translation() = line.departure;
  return frame;
}

DhRow row_between(const Line& from, const Line& to) {
  const Matrix3d former = frame_of(from).linear();
  const Vector3d z = former.transpose() * to.z;
  DhRow row;
  row.a = (to.arrival - from.departure).dot(from.x);
  row.alpha = std::atan2(-z(1), z(2));
  row.beta = std::asin(std::clamp(z(0), -1.0, 1.0));
  const Matrix3d tilted = former * Eigen::AngleAxisd(row.alpha, Vector3d::UnitX()).toRotationMatrix() *
                          Eigen::AngleAxisd(row.beta, Vector3d::UnitY()).toRotationMatrix();
  row.theta = std::atan2(to.x.dot(tilted.col(1)), to.x.dot(tilted.col(0)));
  row.d = (to.departure - to.arrival).dot(to.z);
  row.sign = to.z.dot(to.direction) > 0 ? 1.0 : -1.0;
  return row;
}

}  // namespace

Chain chain_from_axes(const std::vector<JointAxis>& axes, const Isometry3d& tip) {
  std::vector<Line> lines(axes.size() + 1);
  lines[0].point = Vector3d::Zero();
  lines[0].direction = Vector3d::UnitZ();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    lines[i + 1].point = axes[i].origin;
    lines[i + 1].direction = axes[i].direction.normalized();
  }
  find_feet(lines, axes.back().origin);
  choose_z(lines);
  choose_x(lines);
  std::vector<DhRow> rows;
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) rows.push_back(row_between(lines[i], lines[i + 1]));
  return {frame_of(lines.front()), rows, frame_of(lines.back()).inverse() * tip};
}

}  // namespace ballbar

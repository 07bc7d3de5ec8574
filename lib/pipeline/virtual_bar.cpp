#include "pipeline/virtual_bar.hpp"

#include <span>

#include "metrology/arc.hpp"
#include "numerics/circle_fit.hpp"

namespace ballbar {
namespace {

/// Centre of the arc that was driven, in the circle's plane; the configured one where the arc determines
/// none.
Eigen::Vector3d fitted_centre(const Eigen::Matrix3Xd& points, const CircleSpec& circle) {
  const CirclePlane plane = plane_of(circle);
  Eigen::VectorXd angle = angles_on_circle(points, circle);
  const Arc arc = find_arc(angle, circle);
  const auto begin = static_cast<Eigen::Index>(arc.begin);
  const auto count = static_cast<Eigen::Index>(arc.end) - begin;
  const Eigen::Matrix3Xd arms = points.middleCols(begin, count).colwise() - plane.centre;
  Eigen::Matrix2Xd in_plane(2, count);
  in_plane << plane.e1.transpose() * arms, plane.e2.transpose() * arms;
  const CircleFit fit = fit_circle(in_plane);
  if (fit.status != FitStatus::kOk) return plane.centre;
  return plane.centre + fit.centre.x() * plane.e1 + fit.centre.y() * plane.e2;
}

}  // namespace

void add_virtual_bar(Run& run, const TestSpec& test, const RobotModel& model) {
  if (run.kind != TestKind::kCircle || test.kind != TestKind::kCircle || discards(run.end)) return;
  if (!run.bar_time.empty() || run.joint_time.size() < 2 || run.joints != model.joints()) return;
  const auto joints = static_cast<std::size_t>(run.joints);
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(run.joint_time.size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) =
        model.forward(std::span(run.joint_position).subspan(static_cast<std::size_t>(i) * joints, joints))
            .translation();
  const Eigen::Vector3d centre = test.virtual_centre == VirtualCentre::kFitted
                                     ? fitted_centre(points, test.circle)
                                     : plane_of(test.circle).centre;
  run.bar_time = run.joint_time;
  for (const auto& point : points.colwise())
    run.bar_deviation.push_back((point - centre).norm() - test.circle.radius);
  run.virtual_bar = true;
}

}  // namespace ballbar

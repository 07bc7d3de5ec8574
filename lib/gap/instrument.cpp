#include "gap/instrument.hpp"

namespace ballbar {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;

Sight sight_of(const Instrument& instrument, Matrix3Xd points, const Eigen::Vector3d& set_up,
               const Matrix3Xd& ball_moved) {
  points.colwise() -= instrument.origin + set_up;
  points -= ball_moved;
  const Eigen::VectorXd distance = points.colwise().norm().transpose();
  Sight sight{distance.array() - instrument.radius, MatrixXd(points.cols(), 3)};
  for (Index k = 0; k < points.cols(); ++k) sight.along.row(k) = points.col(k).transpose() / distance[k];
  return sight;
}

MatrixXd set_up_columns(const Instrument& /*instrument*/, const MatrixXd& along) { return -along; }

}  // namespace ballbar

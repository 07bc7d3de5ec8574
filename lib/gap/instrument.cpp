#include "gap/instrument.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of a line: offset and rise, and nothing.
MatrixXd alignment(const Instrument& instrument, const VectorXd& place) {
  MatrixXd columns = MatrixXd::Zero(place.size(), 3);
  columns.col(0).setOnes();
  columns.col(1) = 2.0 / instrument.length * place.array() - 1.0;
  return columns;
}

}  // namespace

Sight sight_of(const Instrument& instrument, Matrix3Xd points, const VectorXd& place,
               const Eigen::Vector3d& set_up, const Matrix3Xd& ball_moved) {
  if (!instrument.is_bar()) {
    points.colwise() -= instrument.origin;
    return {points.transpose() * instrument.across + alignment(instrument, place) * set_up,
            instrument.across.transpose().replicate(points.cols(), 1)};
  }
  points.colwise() -= instrument.origin + set_up;
  points -= ball_moved;
  const VectorXd distance = points.colwise().norm().transpose();
  Sight sight{distance.array() - instrument.radius, MatrixXd(points.cols(), 3)};
  for (Index k = 0; k < points.cols(); ++k) sight.along.row(k) = points.col(k).transpose() / distance[k];
  return sight;
}

MatrixXd set_up_columns(const Instrument& instrument, const VectorXd& place, const MatrixXd& along) {
  return instrument.is_bar() ? MatrixXd(-along) : alignment(instrument, place);
}

}  // namespace ballbar

#include "numerics/interpolate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace ballbar {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kAnywhere = std::numeric_limits<double>::infinity();

VectorXd vector(std::initializer_list<double> values) {
  return Eigen::Map<const VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

MatrixXd rows(const VectorXd& x, double (*first)(double), double (*second)(double)) {
  MatrixXd values(2, x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) values.col(i) << first(x[i]), second(x[i]);
  return values;
}

const VectorXd kUneven = vector({-2.0, -1.7, -0.4, 0.0, 0.9, 2.5, 2.6, 4.0});
const VectorXd kBetween = vector({3.9, -2.0, -1.99, 0.0, 1.7, 2.55, 4.0, -1.0});

TEST(Interpolate, ACubicComesBackFromUnevenSamples) {
  const auto cubic = [](double x) { return 2.0 - x + 0.5 * x * x - 0.3 * x * x * x; };
  const auto other = [](double x) { return x * x * x; };
  const MatrixXd found =
      interpolate(kUneven, rows(kUneven, cubic, other), kBetween, kAnywhere, Interpolation::kCubic);
  for (Eigen::Index k = 0; k < kBetween.size(); ++k) {
    EXPECT_NEAR(found(0, k), cubic(kBetween[k]), 1e-12) << kBetween[k];
    EXPECT_NEAR(found(1, k), other(kBetween[k]), 1e-12) << kBetween[k];
  }
}

TEST(Interpolate, StraightLinesNeverLeaveTheirNeighbours) {
  const VectorXd x = vector({0.0, 1.0, 2.0, 3.0});
  MatrixXd step(1, 4);
  step << 0.0, 0.0, 1.0, 1.0;
  const VectorXd at = vector({0.5, 1.25, 1.5, 2.5});
  const MatrixXd found = interpolate(x, step, at, kAnywhere, Interpolation::kLinear);
  EXPECT_EQ(found, (MatrixXd(1, 4) << 0.0, 0.25, 0.5, 1.0).finished());
}

TEST(Interpolate, ASineIsMetToTheFourthOrder) {
  const VectorXd at = VectorXd::LinSpaced(997, 0.3, 5.9);
  double before = 0.0;
  for (const int n : {50, 100, 200}) {
    const VectorXd x = VectorXd::LinSpaced(n + 1, 0.0, 6.2);
    const MatrixXd found =
        interpolate(x, x.array().sin().matrix().transpose(), at, kAnywhere, Interpolation::kCubic);
    const double worst = (found.row(0).transpose().array() - at.array().sin()).abs().maxCoeff();
    if (before > 0.0) {
      EXPECT_NEAR(before / worst, 16.0, 1.5);
    }
    before = worst;
  }
}

TEST(Interpolate, NothingIsSaidOutsideNorAcrossAHole) {
  const VectorXd x = vector({0.0, 1.0, 2.0, 9.0, 10.0});
  const MatrixXd values = x.cwiseAbs2().transpose();
  for (const Interpolation kind : {Interpolation::kLinear, Interpolation::kCubic}) {
    const MatrixXd found = interpolate(x, values, vector({-0.1, 5.0, 10.1, 9.0, 2.0}), 2.0, kind);
    for (const int k : {0, 1, 2}) EXPECT_TRUE(std::isnan(found(0, k))) << k;
    EXPECT_EQ(found(0, 3), 81.0);
    EXPECT_EQ(found(0, 4), 4.0);
  }
  // Beside the hole the polynomial has the samples of its own side only.
  EXPECT_DOUBLE_EQ(interpolate(x, values, vector({1.5}), 2.0, Interpolation::kCubic)(0, 0), 2.25);
  EXPECT_DOUBLE_EQ(interpolate(x, values, vector({9.5}), 2.0, Interpolation::kCubic)(0, 0), 90.5);
}

TEST(Interpolate, RefusesWhatDoesNotRiseAndSizesThatDiffer) {
  const VectorXd at = vector({0.5});
  EXPECT_THROW(interpolate(vector({0, 1, 1}), MatrixXd::Zero(1, 3), at, 9.0, Interpolation::kCubic),
               std::invalid_argument);
  EXPECT_THROW(interpolate(vector({0, 1}), MatrixXd::Zero(1, 3), at, 9.0, Interpolation::kCubic),
               std::invalid_argument);
  EXPECT_EQ(interpolate(VectorXd(), MatrixXd::Zero(2, 0), at, 9.0, Interpolation::kCubic).cols(), 1);
}

}  // namespace
}  // namespace ballbar

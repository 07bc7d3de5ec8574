#include "numerics/line_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ballbar {
namespace {

using Eigen::VectorXd;

TEST(LineFit, HasTheSlopeAndInterceptPrintedInTheManualOfTheHp5528a) {
  // Axis 2 of the example in the manual of the interferometer HP 5528A: x in m, y in um.
  const VectorXd x = VectorXd::LinSpaced(10, 0.0, 0.45);
  VectorXd y(10);
  y << -0.5, -1.2, -2.5, -3.8, -4.0, -4.8, -5.9, -6.2, -7.4, -8.8;
  const LineFit fit = fit_line(x, y);
  ASSERT_EQ(fit.status, FitStatus::kOk);
  EXPECT_NEAR(fit.slope, -17.42, 0.005);
  EXPECT_NEAR(fit.intercept, -0.591, 0.0005);
  EXPECT_NEAR(end_point_line(x, y).slope, -18.44, 0.005);
}

TEST(EndPointLine, HasTheSlopePrintedInTheManualOfTheHp5528aForItsFirstAxis) {
  const VectorXd x = VectorXd::LinSpaced(10, 0.0, 0.9);
  VectorXd y(10);
  y << -0.3, 0.9, 1.5, 2.5, 2.9, 3.6, 4.2, 5.1, 5.9, 7.2;
  EXPECT_NEAR(end_point_line(x, y).slope, 8.33, 0.005);
  EXPECT_NEAR(end_point_line(x, y).intercept, -0.3, 1e-12);
  EXPECT_NEAR(fit_line(x, y).intercept, -0.0945, 0.00005);
}

TEST(LineFit, ItsStandardDeviationsAreThoseOfAThousandRepeatedMeasurements) {
  const unsigned seed = 12;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 0.3);
  const int repeats = 1000;
  const VectorXd x = VectorXd::LinSpaced(20, 4.0, 9.0);
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d claimed = Eigen::Matrix2d::Zero();
  for (int r = 0; r < repeats; ++r) {
    const VectorXd y =
        (2.0 - 0.5 * x.array()) + VectorXd::NullaryExpr(20, [&] { return normal(random); }).array();
    const LineFit fit = fit_line(x, y);
    const Eigen::Vector2d error(fit.intercept - 2.0, fit.slope + 0.5);
    scatter += error * error.transpose() / repeats;
    claimed += fit.covariance / repeats;
  }
  // A variance of 1000 draws is good to 4.5 %; four times that.
  EXPECT_NEAR(scatter(0, 0) / claimed(0, 0), 1.0, 0.18) << "seed " << seed;
  EXPECT_NEAR(scatter(1, 1) / claimed(1, 1), 1.0, 0.18) << "seed " << seed;
  EXPECT_NEAR(scatter(0, 1) / claimed(0, 1), 1.0, 0.18) << "seed " << seed;
}

TEST(EndPointLine, GoesThroughTheMeanOfTheReadingsAtEachEnd) {
  VectorXd x(5);
  VectorXd y(5);
  x << 2.0, 0.0, 1.0, 0.0, 2.0;
  y << 5.0, 1.0, 9.0, 3.0, 7.0;
  const LineFit line = end_point_line(x, y);
  ASSERT_EQ(line.status, FitStatus::kOk);
  EXPECT_DOUBLE_EQ(line.slope, 2.0);
  EXPECT_DOUBLE_EQ(line.intercept, 2.0);
  EXPECT_DOUBLE_EQ(range_about(line.slope, x, y), 6.0);
}

TEST(EndPointLine, CountsPointsWithinTheToleranceToTheEnd) {
  VectorXd x(4);
  VectorXd y(4);
  x << 0.0, 0.1, 4.9, 5.0;
  y << 0.0, 2.0, 6.0, 8.0;
  const LineFit line = end_point_line(x, y, 0.2);
  EXPECT_DOUBLE_EQ(line.slope, 6.0 / 4.9);
}

TEST(LineFit, SaysSoWhereThePointsDetermineNoLine) {
  EXPECT_EQ(fit_line(VectorXd::Zero(1), VectorXd::Zero(1)).status, FitStatus::kTooFewPoints);
  EXPECT_EQ(fit_line(VectorXd::Constant(6, 0.3), VectorXd::Random(6)).status, FitStatus::kIllConditioned);
  EXPECT_EQ(end_point_line(VectorXd::Constant(6, 0.3), VectorXd::Random(6)).status,
            FitStatus::kIllConditioned);
  const LineFit exact = fit_line(Eigen::Vector2d(1.0, 2.0), Eigen::Vector2d(5.0, 3.0));
  EXPECT_DOUBLE_EQ(exact.slope, -2.0);
  EXPECT_EQ(exact.residual_sd, 0.0);
}

TEST(LineFit, RefusesWhatIsNotFiniteOrDoesNotFit) {
  EXPECT_THROW(fit_line(VectorXd::Zero(3), VectorXd::Zero(2)), std::invalid_argument);
  EXPECT_THROW(fit_line(VectorXd::Zero(3), VectorXd::Constant(3, std::nan(""))), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar

// The paper's own simulation (Creo, Table 1) and the sensitivities of metrology.md 6.1: figures of an
// independent script, through inverse kinematics, forward kinematics as built and the bar.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "gap/paper_robot.hpp"

namespace ballbar {
namespace {

using nlohmann::json;
using test::fitted_circle;
using test::harmonic;

const std::filesystem::path kOracles = std::filesystem::path(BALLBAR_SHARED_DIR) / "data" / "oracles";
constexpr double kOffsetsDeg[6] = {1.2, 2.3, -1.5, -3.2, -2.8, 0.9};

/// Samples a turn of the script whose extremes of the trace are compared.
constexpr double kGrid = 720.0;

std::vector<EffectSpec> table1(double sign, bool coupled) {
  std::vector<EffectSpec> effects;
  for (int j = 0; j < 6; ++j) {
    const double with_j2 = coupled && j == 2 ? kOffsetsDeg[1] : 0.0;
    effects.push_back(test::zero_offset(j + 1, sign * (kOffsetsDeg[j] + with_j2)));
  }
  return effects;
}

json oracles() {
  std::ifstream file(kOracles / "lrmate200ic_ballbar_oracles.json");
  return json::parse(file);
}

class Oracles : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kOracles)) GTEST_SKIP() << "no oracles at " << kOracles;
  }
};

TEST_F(Oracles, Table1InAll16Variants) {
  const json cases = oracles()["table1"];
  ASSERT_EQ(cases.size(), 16u);
  for (const auto& [name, expected] : cases.items()) {
    SCOPED_TRACE(name);
    TestSpec test = test::paper_circle(name.substr(0, 1));
    const bool flipped = name.find("|FUT|") != std::string::npos;
    if (flipped) test.posture = {0, 0, 0, 180 * test::kDeg, 0, 0};
    test.feed = 246.0 * 2.0 * std::numbers::pi * test.circle.radius / kGrid;
    const SimulatedRun run = fitted_circle(test, table1(name.find("sign+1") != std::string::npos ? 1.0 : -1.0,
                                                        name.find("coupled") != std::string::npos));
    ASSERT_EQ(run.angle.size(), static_cast<Eigen::Index>(kGrid));
    EXPECT_NEAR(harmonic(run, 0).real() * 1e6, expected["mean_um"].get<double>(), 1e-4);
    for (int k = 1; k <= 10; ++k) {
      SCOPED_TRACE("order " + std::to_string(k));
      const std::complex<double> h = harmonic(run, k) * 1e6;
      EXPECT_NEAR(h.real(), expected["a_um"][k - 1].get<double>(), 1e-4);
      EXPECT_NEAR(h.imag(), expected["b_um"][k - 1].get<double>(), 1e-4);
    }
    EXPECT_NEAR((run.deviation.maxCoeff() - run.deviation.minCoeff()) * 1e6, expected["p2p_um"].get<double>(),
                1e-4);
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR((run.ball[i] - test.circle.centre[static_cast<std::size_t>(i)]) * 1e3,
                  expected["centre_shift_mm"][static_cast<std::size_t>(i)].get<double>(), 1e-5);
  }
}

TEST_F(Oracles, TheRowsOfCircleBThroughInverseKinematicsAndBothTools) {
  std::ifstream file(kOracles / "circle_B_table1.csv");
  TestSpec test = test::paper_circle("B");
  test.circle.overshoot = 0.0;
  const double turn = 2.0 * std::numbers::pi * test.circle.radius / test.feed;
  const RobotModel model = test::lrmate();
  const CommandedPath path = commanded_circle(model, test, 1, test.feed, 72.0 / turn);
  ASSERT_EQ(path.arc_begin, 0);
  ASSERT_EQ(path.arc_end, 72);
  const AsBuilt as_built(model, test::paper_robot({}, table1(1.0, false)));
  const Eigen::Matrix3Xd true_points = as_built.tool_points(path.motion, {});
  std::string line;
  std::getline(file, line);
  int rows = 0;
  for (; std::getline(file, line); ++rows) {
    SCOPED_TRACE(line);
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream fields(line);
    double theta = 0.0;
    fields >> theta;
    EXPECT_NEAR(path.angle[rows] / test::kDeg, theta, 1e-9);
    std::vector<double> q(path.motion.q.col(rows).begin(), path.motion.q.col(rows).end());
    model.from_chain(q);
    for (int j = 0; j < 6; ++j) {
      double expected_deg = 0.0;
      fields >> expected_deg;
      EXPECT_NEAR(q[static_cast<std::size_t>(j)] / test::kDeg, expected_deg, 1e-8) << "J" << j + 1;
    }
    for (const Eigen::Matrix3Xd& points : {path.points, true_points})
      for (int i = 0; i < 3; ++i) {
        double expected_mm = 0.0;
        fields >> expected_mm;
        EXPECT_NEAR(points(i, rows) * 1e3, expected_mm, 1e-7);
      }
    EXPECT_TRUE(fields) << "13 numbers a row";
  }
  EXPECT_EQ(rows, 72);
}

}  // namespace
}  // namespace ballbar

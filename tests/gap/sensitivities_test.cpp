// What each joint, length and twist does to circle and line: metrology.md 6.1 and the oracle's columns,
// figures of an independent script.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "gap/paper_robot.hpp"
#include "metrology/line.hpp"

namespace ballbar {
namespace {

using Complex = std::complex<double>;
using nlohmann::json;
using test::fitted_circle;
using test::harmonic;

constexpr double kArcminDeg = 1.0 / 60.0;

/// Few samples a turn and no overshoot, for it makes no difference.
TestSpec quick(const std::string& circle) {
  TestSpec test = test::paper_circle(circle);
  test.circle.overshoot = 0.0;
  test.feed = 246.0 * 2.0 * std::numbers::pi * test.circle.radius / 180.0;
  return test;
}

/// Orders 0..10 [um] that a small deviation adds: half the difference between it and its opposite.
std::vector<Complex> effect_um(const std::string& circle, const EffectSpec& plus) {
  EffectSpec minus = plus;
  for (auto& [name, value] : minus.parameters) value = -value;
  const SimulatedRun up = fitted_circle(quick(circle), {plus});
  const SimulatedRun down = fitted_circle(quick(circle), {minus});
  std::vector<Complex> orders;
  for (int k = 0; k <= 10; ++k) orders.push_back((harmonic(up, k) - harmonic(down, k)) * 0.5e6);
  return orders;
}

/// Turned into the frame whose first axis points from the J1 axis to the circle's centre.
Complex local(const std::string& circle, const std::vector<Complex>& orders, int k) {
  const Vec3 centre = test::paper_circle(circle).circle.centre;
  return orders[static_cast<std::size_t>(k)] * std::polar(1.0, -k * std::atan2(centre[1], centre[0]));
}

TEST(Sensitivities, OneArcminuteOfEachJointIsTheOraclesColumn) {
  const std::filesystem::path path =
      std::filesystem::path(BALLBAR_SHARED_DIR) / "data/oracles/lrmate200ic_ballbar_oracles.json";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no oracles at " << path;
  std::ifstream file(path);
  const json columns = json::parse(file)["sens_per_arcmin"];
  ASSERT_EQ(columns.size(), 12u);
  for (const auto& [name, expected] : columns.items()) {
    SCOPED_TRACE(name);
    const std::string circle = name.substr(0, 1);
    const std::vector<Complex> found = effect_um(circle, test::zero_offset(name.back() - '0', kArcminDeg));
    EXPECT_NEAR(found[0].real(), expected["mean_um"].get<double>(), 1e-5);
    for (std::size_t k = 1; k <= 10; ++k) {
      EXPECT_NEAR(found[k].real(), expected["a_um"][k - 1].get<double>(), 1e-5) << "order " << k;
      EXPECT_NEAR(found[k].imag(), expected["b_um"][k - 1].get<double>(), 1e-5) << "order " << k;
    }
    const Complex h2 = local(circle, found, 2);
    EXPECT_NEAR(h2.real(), expected["local_h2"][0].get<double>(), 1e-5);
    EXPECT_NEAR(h2.imag(), expected["local_h2"][1].get<double>(), 1e-5);
  }
}

TEST(Sensitivities, TheTableOfJointsOnBothCircles) {
  struct Row {
    int joint;
    double mean_um;
    Complex h2_um, h3_um;
  };
  const Row table[] = {{1, 0.0, 0.0, 0.0},         {2, -7.386, 7.198, -1.086},
                       {3, 5.842, -18.921, 1.984}, {4, 0.0, {0.0, -3.625}, {0.0, 0.510}},
                       {5, 4.551, -4.435, 0.669},  {6, 0.0, 0.0, 0.0}};
  for (const Row& row : table)
    for (const std::string circle : {"A", "B"}) {
      SCOPED_TRACE("J" + std::to_string(row.joint) + " on " + circle);
      const std::vector<Complex> found = effect_um(circle, test::zero_offset(row.joint, kArcminDeg));
      EXPECT_NEAR(found[0].real(), row.mean_um, 6e-4);
      EXPECT_NEAR(std::abs(local(circle, found, 2) - row.h2_um), 0.0, 6e-4) << local(circle, found, 2);
      EXPECT_NEAR(std::abs(local(circle, found, 3) - row.h3_um), 0.0, 6e-4) << local(circle, found, 3);
    }
}

TEST(Sensitivities, TheTableOfLengthsAndTwists) {
  struct Row {
    const char* name;
    EffectSpec effect;
    double mean_um;
    Complex h2_um;
  };
  const Row table[] = {
      {"a1", test::geometry(2, "a_mm", 0.1), 10.12, -9.86},
      {"a2", test::geometry(3, "a_mm", 0.1), 13.48, -2.73},
      {"a3", test::geometry(4, "a_mm", 0.1), 4.92, -13.67},
      {"d4", test::geometry(4, "d_mm", 0.1), 15.09, 8.08},
      {"d6", {"tool_offset", 0, {{"z_mm", 0.1}}, {}}, 0.0, 0.0},
      {"J1/J2 squareness", test::geometry(2, "alpha_deg", kArcminDeg), 0.0, {0.0, -7.27}},
      {"J2/J3 parallelism", test::geometry(3, "alpha_deg", kArcminDeg), 0.0, {0.0, -10.10}},
  };
  for (const Row& row : table)
    for (const std::string circle : {"A", "B"}) {
      SCOPED_TRACE(std::string(row.name) + " on " + circle);
      const std::vector<Complex> found = effect_um(circle, row.effect);
      EXPECT_NEAR(found[0].real(), row.mean_um, 6e-3);
      EXPECT_NEAR(std::abs(local(circle, found, 2) - row.h2_um), 0.0, 7e-3) << local(circle, found, 2);
    }
}

/// Readings of one simulated run forward, by axis.
std::map<char, LineResult> line_with(std::vector<EffectSpec> effects) {
  SimulateOptions options;
  options.directions = {1};
  const SimulatedRun run =
      test::simulated(test::paper_robot({test::paper_line()}, std::move(effects)), options).front();
  std::map<char, std::vector<InterferometerReading>> readings;
  for (const Sample& sample : run.samples)
    if (const auto* block = std::get_if<InterferometerBlock>(&sample))
      readings[block->axis].push_back({block->axis, 0.0, block->position.at(0), block->deviation.at(0)});
  std::map<char, LineResult> lines;
  for (const auto& [axis, points] : readings) lines[axis] = analyse_line(points).value();
  return lines;
}

TEST(Sensitivities, TheTableOfJointsOnTheLine) {
  struct Row {
    int joint;
    double x_mz, x_ls, x_ep, z_mz;  // [um] per arcminute; 0 where the table gives the minimum zone only
  };
  const Row table[] = {{1, 0, 0, 0, 0},           {2, 27.11, 0, 0, 65.28}, {3, 69.38, 0, 0, 44.78},
                       {4, 6.97, 9.39, 10.15, 0}, {5, 16.70, 0, 0, 0},     {6, 0, 0, 0, 0}};
  for (const Row& row : table) {
    SCOPED_TRACE("J" + std::to_string(row.joint));
    std::map<char, LineResult> lines = line_with({test::zero_offset(row.joint, kArcminDeg)});
    ASSERT_EQ(lines.size(), 2u) << "the two axes across the line";
    ASSERT_EQ(lines['X'].points.size(), 51u);
    ASSERT_EQ(lines['Z'].points.size(), 51u);
    EXPECT_NEAR(lines['X'].straightness_mz * 1e6, row.x_mz, 0.02);
    EXPECT_NEAR(lines['Z'].straightness_mz * 1e6, row.z_mz, 0.02);
    if (row.x_ls > 0) {
      EXPECT_NEAR(lines['X'].straightness_ls * 1e6, row.x_ls, 0.02);
      EXPECT_NEAR(lines['X'].straightness_ep * 1e6, row.x_ep, 0.02);
    }
  }
}

TEST(Sensitivities, TheTableOfJointsOnTheLengthOfTheLine) {
  const double table_um[] = {0, -113.6, 165.4, 0, 70.0, 0};  // per arcminute
  const CommandedPath path = commanded_line(test::lrmate(), test::paper_line(), 1, 0.05533, 0.1, 20.0);
  for (int joint = 1; joint <= 6; ++joint) {
    const AsBuilt as_built(test::lrmate(), test::paper_robot({}, {test::zero_offset(joint, kArcminDeg)}));
    const Eigen::Matrix3Xd points = as_built.tool_points(path.motion, {});
    const double length = points(1, points.cols() - 1) - points(1, 0);
    EXPECT_NEAR((length - 0.940) * 1e6, table_um[joint - 1], 0.06) << "J" << joint;
  }
}

}  // namespace
}  // namespace ballbar

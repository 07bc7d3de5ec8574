#include "metrology/volumetric.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>

#include "core/units.hpp"
#include "metrology/arc.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kVolumetricRadius = 0.15;

/// A machine with slides: where X, Y and Z really point, and how far they really go.
struct Machine {
  Vector3d scaling = Vector3d::Zero();
  double xy = 0.0, yz = 0.0, zx = 0.0;  ///< [rad] angle between the axes, less 90 degrees

  /// Columns: what one commanded metre of each axis does. X is as it should be, Y lies in XY, and Z fills the
  /// rest: angles by their cosines alone.
  Matrix3d axes() const {
    const Vector3d x(1.0, 0.0, 0.0);
    const Vector3d y(std::cos(kPi / 2 + xy), std::sin(kPi / 2 + xy), 0.0);
    const double zx_cos = std::cos(kPi / 2 + zx);
    const double zy = (std::cos(kPi / 2 + yz) - zx_cos * y.x()) / y.y();
    const Vector3d z(zx_cos, zy, std::sqrt(1.0 - zx_cos * zx_cos - zy * zy));
    Matrix3d all;
    all << (1 + scaling.x()) * x, (1 + scaling.y()) * y, (1 + scaling.z()) * z;
    return all;
  }
};

/// 50, 40 and -70 um/m of scaling; 30, -60 and 90 um/m of squareness.
Machine worn() { return {{50e-6, 40e-6, -70e-6}, 30e-6, -60e-6, 90e-6}; }

using Extra = std::function<double(double, int)>;  // [m] of the bar, by angle and direction

PlaneTrace drive(const Machine& machine, const std::string& plane, double start_deg, double sweep_deg,
                 int direction, const Vector3d& ball, const Extra& extra) {
  constexpr int kSamples = 900;
  PlaneTrace made{"test " + plane, *plane_named(plane, kVolumetricRadius), {}};
  const CirclePlane frame = plane_of(made.spec);
  made.trace.direction = direction;
  made.trace.angle.resize(kSamples);
  made.trace.deviation.resize(kSamples);
  for (Index i = 0; i < kSamples; ++i) {
    const double share = (static_cast<double>(i) + 0.5) / kSamples;
    const double angle = (start_deg + sweep_deg * (direction > 0 ? share : 1.0 - share)) * kRadPerDeg;
    const Vector3d commanded = kVolumetricRadius * (std::cos(angle) * frame.e1 + std::sin(angle) * frame.e2);
    made.trace.angle[i] = angle;
    made.trace.deviation[i] =
        (machine.axes() * commanded - ball).norm() - kVolumetricRadius + extra(angle, direction);
  }
  return made;
}

/// As Ballbar 20 has them driven: all of XY, 220 degrees of the planes that stand upright, both ways.
std::vector<PlaneTrace> three_planes(const Machine& machine, const Vector3d& ball, const Extra& extra) {
  std::vector<PlaneTrace> all;
  for (const int way : {1, -1}) {
    all.push_back(drive(machine, "XY", 0, 360, way, ball, extra));
    all.push_back(drive(machine, "YZ", -20, 220, way, ball, extra));
    all.push_back(drive(machine, "ZX", -110, 220, way, ball, extra));
  }
  return all;
}

void expect_worn(const Volumetric& found, double tolerance) {
  const Machine truth = worn();
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(found.scaling[k].value, truth.scaling[static_cast<Index>(k)], tolerance) << kAxes[k];
  EXPECT_NEAR(found.squareness[0].value, truth.xy, tolerance);
  EXPECT_NEAR(found.squareness[1].value, truth.yz, tolerance);
  EXPECT_NEAR(found.squareness[2].value, truth.zx, tolerance);
}

double nothing(double, int) { return 0.0; }

TEST(Volumetric, FindsTheMachineThatDroveThreePlanes) {
  // 0.05 um/m: products of the errors, and what the ball's place leaves.
  for (const Vector3d& ball : {Vector3d(0, 0, 0), Vector3d(40e-6, -30e-6, 20e-6)}) {
    const auto found = analyse_volumetric(three_planes(worn(), ball, nothing));
    ASSERT_TRUE(found);
    expect_worn(*found, 0.05e-6);
    EXPECT_LT(found->residual, 0.05e-6);
  }
}

TEST(Volumetric, AQuadrantThatIsDrivenBackwardsIsTheSameMachine) {
  std::vector<PlaneTrace> all;
  for (const int way : {1, -1}) {
    all.push_back(drive(worn(), "XY, normal -Z, angle 0 on -Y", 0, 360, way, Vector3d::Zero(), nothing));
    all.push_back(drive(worn(), "YZ, normal -X, angle 0 on Z", 0, 220, way, Vector3d::Zero(), nothing));
    all.push_back(drive(worn(), "ZX, normal Y, angle 0 on X", -20, 220, way, Vector3d::Zero(), nothing));
  }
  const auto found = analyse_volumetric(all);
  ASSERT_TRUE(found);
  expect_worn(*found, 0.05e-6);
}

TEST(Volumetric, ServoMismatchAndALargeBallOffsetAreNoSquareness) {
  // 12 um at 45 degrees that change sides with the direction, and other samples one way than the other.
  const Extra lag = [](double a, int way) { return way * (12e-6 * std::sin(2 * a) + 5e-6 * std::cos(a)); };
  std::vector<PlaneTrace> all = three_planes(worn(), Vector3d(0.3e-3, 0.2e-3, 0.0), lag);
  CircleTrace& fewer = all.front().trace;
  fewer.angle = fewer.angle.head(600).eval();
  fewer.deviation = fewer.deviation.head(600).eval();
  const auto found = analyse_volumetric(all);
  ASSERT_TRUE(found);
  expect_worn(*found, 2.2e-6);  // 0.3 mm out of the plane YZ are 0.3 um of the bar: e^2 / 2R^2 = 2 um/m
}

TEST(Volumetric, StandardDeviationsAreTheScatterOfRepeatedSetUps) {
  const unsigned seed = 5;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1e-6);
  const Extra noise = [&](double, int) { return normal(random); };
  std::array<double, 6> scatter{}, claimed{};
  const Machine truth = worn();
  const std::array<double, 6> right{truth.scaling.x(), truth.scaling.y(), truth.scaling.z(),
                                    truth.xy,          truth.yz,          truth.zx};
  for (int repeat = 0; repeat < 60; ++repeat) {
    const auto found = analyse_volumetric(three_planes(truth, Vector3d::Zero(), noise));
    ASSERT_TRUE(found);
    for (std::size_t k = 0; k < 6; ++k) {
      const Estimate& one = k < 3 ? found->scaling[k] : found->squareness[k - 3];
      scatter[k] += std::pow(one.value - right[k], 2);
      claimed[k] += std::pow(*one.sd, 2);
    }
  }
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(std::sqrt(scatter[k] / claimed[k]), 1.0, 0.3) << k;
}

TEST(Volumetric, RepetitionsDoNotNarrowWhatTheModelLeaves) {
  const Extra lobes = [](double a, int) { return 3e-6 * std::cos(3 * a) + 1e-6 * std::cos(5 * a); };
  const std::vector<PlaneTrace> once = three_planes(worn(), Vector3d::Zero(), lobes);
  std::vector<PlaneTrace> often;
  for (int k = 0; k < 5; ++k) often.insert(often.end(), once.begin(), once.end());
  const auto one = analyse_volumetric(once);
  const auto five = analyse_volumetric(often);
  ASSERT_TRUE(one && five);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(five->squareness[k].value, one->squareness[k].value, 1e-9);
    EXPECT_NEAR(*five->squareness[k].sd / *one->squareness[k].sd, 1.0, 0.2);
  }
}

TEST(Volumetric, NeedsThreePlanesDrivenBothWays) {
  const std::vector<PlaneTrace> all = three_planes(worn(), Vector3d::Zero(), nothing);
  EXPECT_FALSE(analyse_volumetric({}));
  EXPECT_FALSE(analyse_volumetric({all.begin(), all.begin() + 3})) << "one way only";
  for (const std::size_t without : {0u, 1u, 2u}) {
    std::vector<PlaneTrace> two = all;
    two.erase(two.begin() + static_cast<std::ptrdiff_t>(without));
    EXPECT_FALSE(analyse_volumetric(two)) << "a way of " << all[without].test << " is missing";
  }
  std::vector<PlaneTrace> bad = all;
  bad.front().trace.direction = 0;
  EXPECT_THROW(analyse_volumetric(bad), std::invalid_argument);
}

TEST(PlaneNamed, IsThePlaneWhoseNameItIs) {
  for (const char* name : {"XY", "YZ", "ZX", "ZX, normal Y, angle 0 on X", "XY, normal -Z, angle 0 on -Y"}) {
    const auto spec = plane_named(name, kVolumetricRadius);
    ASSERT_TRUE(spec) << name;
    EXPECT_EQ(plane_name(*spec), name);
    EXPECT_EQ(spec->radius, kVolumetricRadius);
  }
  EXPECT_FALSE(plane_named("normal (0.6, 0, 0.8), angle 0 on Y", kVolumetricRadius));
  EXPECT_FALSE(plane_named("", kVolumetricRadius));
}

}  // namespace
}  // namespace ballbar

#include "gap/proposed_parts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "gap/commanded_path.hpp"

namespace ballbar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Vec3 vec3_of(const Vector3d& v) { return {v[0], v[1], v[2]}; }

Vec3 rpy_of(const Matrix3d& r) {
  return {std::atan2(r(2, 1), r(2, 2)), std::asin(std::clamp(-r(2, 0), -1.0, 1.0)),
          std::atan2(r(1, 0), r(0, 0))};
}

Matrix3d turn_about(int axis, double angle) {
  return Eigen::AngleAxisd(angle, Vector3d::Unit(axis)).toRotationMatrix();
}

std::string tilt_words(int axis, double angle) {
  return " tilted by " + std::to_string(std::lround(angle / kRadPerDeg)) + " deg about " + "XYZ"[axis];
}

std::string joined(const std::string& a, const std::string& b) {
  return a.empty() ? b : b.empty() ? a : a + ", " + b;
}

bool within_joint_speeds(const RobotModel& model, const Motion& motion) {
  constexpr double kOfSpeedLimit = 0.8;
  const Index n = motion.q.cols();
  for (Index j = 0; j < motion.q.rows(); ++j) {
    const double limit = model.limits()[static_cast<std::size_t>(j)].velocity;
    const double fastest = ((motion.q.row(j).tail(n - 1) - motion.q.row(j).head(n - 1)).array() /
                            (motion.time.tail(n - 1) - motion.time.head(n - 1)).transpose().array())
                               .abs()
                               .maxCoeff();
    if (limit > 0.0 && fastest > kOfSpeedLimit * limit) return false;
  }
  return true;
}

std::optional<Matrix3d> known_tool_orientation(const RobotModel& model, const TestSpec& test) {
  try {
    return tool_orientation(model, test);
  } catch (const Error&) {
    return std::nullopt;
  }
}

double heavy_of(const RobotSpec& robot) {
  constexpr double kMoreLoad = 2.0;
  double lightest = robot.payload, heaviest = robot.payload;
  for (const TestSpec& test : robot.tests) {
    lightest = std::min(lightest, test.payload.value_or(robot.payload));
    heaviest = std::max(heaviest, test.payload.value_or(robot.payload));
  }
  return heaviest > lightest + 0.5 ? heaviest : lightest + kMoreLoad;
}

std::string TestNames::next(const std::string& after) {
  std::string name;
  do {
    name = after + "-" + std::to_string(++number_);
  } while (robot_.find_test(name));
  return name;
}

void add_variants(const GapModel& model, const ProposedTest& plain, double heavy,
                  const std::function<bool(const TestSpec&)>& can_be_driven,
                  const std::function<void(ProposedTest, const std::string&)>& add) {
  add(plain, "");
  const double light = plain.test.payload.value_or(model.spec().payload);
  if (std::abs(heavy - light) > 0.1 && model.loads_known()) {
    ProposedTest loaded = plain;
    loaded.test.payload = heavy;
    add(std::move(loaded), to_hundredths(heavy) + " kg");
  }
  ProposedTest fast = plain;
  fast.test.feed *= kFasterFeed;
  if (can_be_driven(fast.test)) add(std::move(fast), "twice the feed");
}

void leave_unmeasured(Observation& seen, const LapNoise& noise, double sparser) {
  constexpr Index kLaps = 2;
  const Eigen::VectorXd& frequency = seen.transform.frequency();
  seen.variance.resize(frequency.size());
  for (Index k = 0; k < frequency.size(); ++k) {
    const auto above = std::lower_bound(noise.frequency.begin(), noise.frequency.end(), frequency[k]);
    const Index at = std::min<Index>(above - noise.frequency.begin(), noise.frequency.size() - 1);
    seen.variance[k] = noise.variance[at] * sparser / kLaps;
  }
  seen.measured = Eigen::VectorXd::Zero(frequency.size());
  seen.laps = Eigen::MatrixXd::Zero(frequency.size(), kLaps);
}

}  // namespace ballbar

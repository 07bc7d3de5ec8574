// Lost motion against twins that are written otherwise: positions of link and flanks instead of a place in
// the play, springs at the flanks in microseconds instead of plastic stops in milliseconds.

#include <gtest/gtest.h>

#include <random>

#include "physics/physics_test.hpp"
#include "physics/play.hpp"

namespace ballbar {
namespace {

using test::effect;

constexpr double kWidth = 0.01 * kRadPerDeg;  // the full play of all robots here

EffectSpec lost(const std::string& kind, std::map<std::string, double> more = {}) {
  more["width_deg"] = 0.01;
  return effect("joint_lost_motion", 1, more, {{"kind", kind}});
}

/// The link is carried by whichever flank touches it, or pressed to one by a load above the friction.
Eigen::VectorXd twin(const Eigen::VectorXd& q, const std::function<double(int)>& half,
                     const std::function<int(int)>& pressed) {
  Eigen::VectorXd out(q.size());
  double link = q(0);
  for (int k = 0; k < q.size(); ++k) {
    const double low = q(k) - half(k), high = q(k) + half(k);
    if (pressed(k) > 0) link = low;
    if (pressed(k) < 0) link = high;
    if (link < low) link = low;
    if (link > high) link = high;
    out(k) = link - q(k);
  }
  return out;
}

Motion wander(unsigned seed, int n) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> kick(0.0, 0.4 * kWidth);
  Motion motion = test::single(n, 100, [](double) { return 0.0; });
  for (int k = 1; k < n; ++k) motion.q(0, k) = motion.q(0, k - 1) + kick(random);
  return motion;
}

Eigen::VectorXd deflection(const AsBuilt& robot, const Motion& motion) {
  return (robot.link_angles(motion, {}) - motion.q).row(0).transpose();
}

TEST(LostMotion, WindUpIsPlayWhateverTheLoad) {
  const Motion motion = wander(4, 5000);
  SCOPED_TRACE("random 4");
  const Eigen::VectorXd want = twin(
      motion.q.row(0), [](int) { return kWidth / 2; }, [](int) { return 0; });
  for (const EffectSpec& spec : {lost("friction_windup"), lost("friction_windup", {{"friction_nm", 0.5}}),
                                 lost("unresolved"), lost("backlash")})
    EXPECT_LT((deflection(test::arm_with({spec}), motion) - want).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(LostMotion, TheFullWidthLiesBetweenBothDirections) {
  const Motion there_and_back =
      test::single(2001, 100, [](double t) { return 0.1 * (1 - std::cos(kPi * t / 10)); });
  const Eigen::VectorXd d = deflection(test::arm_with({lost("unresolved")}), there_and_back);
  EXPECT_NEAR(d(500), -kWidth / 2, 1e-15);  // driven in + sense the link is behind
  EXPECT_NEAR(d(1500), kWidth / 2, 1e-15);
}

TEST(LostMotion, OfLoadFrictionGrowsWithTheLoad) {
  // Gravity of the arm: 2 kg x 0.3 m x cos(angle), inertia left out by moving slowly.
  const Motion motion = test::single(4000, 100, [](double t) { return 0.8 * std::sin(0.3 * t); });
  const AsBuilt robot = test::arm_with({lost("load_friction", {{"friction_nm", 4.0}})});
  const Eigen::VectorXd got = deflection(robot, motion);
  for (int k = 100; k < 4000; ++k) {
    const double t = motion.time(k);
    if (std::abs(std::cos(0.3 * t)) < 0.05) continue;  // on the way across
    const double load =
        2 * 9.80665 * 0.3 * std::cos(motion.q(0, k)) - (2 * 0.09 + 0.02) * 0.8 * 0.09 * std::sin(0.3 * t);
    const double want = -kWidth / 2 * load / 4.0 * (std::cos(0.3 * t) > 0 ? 1 : -1);
    EXPECT_NEAR(got(k), want, 1e-4 * kWidth) << "t " << t;
  }
}

TEST(LostMotion, OfAShrinkingPlayKeepsToTheFlanks) {
  const Motion motion = wander(9, 3000);
  SCOPED_TRACE("random 9");
  Eigen::VectorXd half(3000);
  for (int k = 0; k < 3000; ++k) half(k) = k < 1000 ? kWidth : k < 2000 ? 0.0 : kWidth / 3;
  const Eigen::VectorXd got = play(motion.q.row(0).transpose(), half);
  const Eigen::VectorXd want = twin(
      motion.q.row(0), [&](int k) { return half(k); }, [](int) { return 0; });
  EXPECT_LT((got - want).head(2000).cwiseAbs().maxCoeff(), 1e-15);
  // Where it opens again the one keeps its side, the other its place: the same once the play was crossed.
  EXPECT_LT((got - want).tail(800).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Backlash, IsPinnedWhileTheLoadExceedsTheFriction) {
  // 5.9 Nm x cos(angle) never changes sign here: the arm always hangs on the same flank.
  const Motion motion = test::single(2000, 100, [](double t) { return 0.5 * std::sin(0.4 * t); });
  const AsBuilt robot = test::arm_with({lost("backlash", {{"friction_nm", 2.0}})});
  EXPECT_LT((deflection(robot, motion).array() + kWidth / 2).abs().maxCoeff(), 1e-15);
}

TEST(Backlash, SlowlyAndHeldByFrictionIsPlay) {
  const Motion motion = test::single(4000, 100, [](double t) { return 0.3 * std::sin(0.4 * t); });
  const AsBuilt robot = test::arm_with({lost("backlash", {{"friction_nm", 8.0}})});
  const Eigen::VectorXd want = twin(
      motion.q.row(0), [](int) { return kWidth / 2; }, [](int) { return 0; });
  // The motor's speed comes from a parabola through its angles, so places agree to that.
  EXPECT_LT((deflection(robot, motion) - want).tail(3500).cwiseAbs().maxCoeff(), 0.02 * kWidth);
}

TEST(Backlash, SlowlyFollowsALoadThatPassesTheFriction) {
  // The arm swings over the top, where gravity changes sign: pinned, held, pinned to the other flank.
  const Motion motion = test::single(8000, 100, [](double t) { return kPi / 2 + 1.2 * std::sin(0.1 * t); });
  const AsBuilt robot = test::arm_with({lost("backlash", {{"friction_nm", 1.0}})});
  const auto load = [&](int k) { return 2 * 9.80665 * 0.3 * std::cos(motion.q(0, k)); };
  const Eigen::VectorXd want = twin(
      motion.q.row(0), [](int) { return kWidth / 2; },
      [&](int k) { return load(k) > 1.0    ? 1
                          : load(k) < -1.0 ? -1
                                           : 0; });
  const Eigen::VectorXd got = deflection(robot, motion);
  int compared = 0;
  for (int k = 0; k < 8000; ++k) {
    if (std::abs(std::abs(load(k)) - 1.0) < 0.1) continue;  // falls across the gap in a tenth of a second
    ++compared;
    EXPECT_NEAR(got(k), want(k), 0.02 * kWidth) << "t " << motion.time(k) << " load " << load(k);
  }
  EXPECT_GT(compared, 6000);
  EXPECT_GT(got.maxCoeff() - got.minCoeff(), 0.99 * kWidth);
}

TEST(Backlash, AtStaticPosesMinutesApartIsPinnedByTheLoad) {
  // Left, over the top, right: 5.9 Nm x cos(angle) on one flank, held, on the other.
  Motion poses{Eigen::VectorXd::LinSpaced(6, 0, 1e6), Eigen::MatrixXd(1, 6)};
  poses.q << 0.2, 0.9, 1.2, 1.9, 2.4, 2.9;
  const Eigen::VectorXd got = deflection(test::arm_with({lost("backlash", {{"friction_nm", 1.0}})}), poses);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(got(k), (k < 3 ? -1 : 1) * kWidth / 2, 1e-15) << "pose " << k;
}

/// Flanks as stiff, damped springs; friction that takes 1e-5 rad/s to build up; 2 us.
Eigen::VectorXd with_contacts(const std::function<double(double)>& q, double w, double inertia, double half,
                              double friction, const std::function<double(double)>& gravity, double end,
                              double every) {
  const double stiffness = 1e6, damping = 2 * std::sqrt(stiffness * inertia), h = 2e-6;
  std::vector<double> out;
  double link = q(0), speed = 0.0;
  long next = 0;
  const long steps = static_cast<long>(end / h);
  for (long i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) * h;
    const double motor = q(t);
    if (t >= static_cast<double>(next) * every - h / 2) {
      out.push_back(link - motor);
      ++next;
    }
    const double motor_speed = (q(t + 1e-6) - q(t - 1e-6)) / 2e-6;
    double force = -gravity(t) - friction * std::tanh(speed / (1e-5 * w));
    const double in_low = (motor - half) - link, in_high = link - (motor + half);
    if (in_low > 0) force += std::max(0.0, stiffness * in_low - damping * (speed - motor_speed));
    if (in_high > 0) force -= std::max(0.0, stiffness * in_high + damping * (speed - motor_speed));
    // Implicit in the friction's slope, which is far steeper than the step.
    const double slope =
        friction / (1e-5 * w) / std::pow(std::cosh(std::min(50.0, std::abs(speed) / (1e-5 * w))), 2);
    speed += h * force / (inertia + h * slope);
    link += h * speed;
  }
  return Eigen::Map<Eigen::VectorXd>(out.data(), static_cast<Eigen::Index>(out.size()));
}

// An upright axis that reverses twice a second: the link coasts through the gap before the motor has turned.
TEST(Backlash, FastCoastsAsALinkBetweenSpringsDoes) {
  const double inertia = 2 * 0.09 + 0.02, w = 6.0;
  const auto q = [&](double t) { return 0.02 * (1 - std::cos(w * t)); };
  for (const double friction : {0.01, 0.05, 0.4}) {
    SCOPED_TRACE("friction " + std::to_string(friction) + " Nm; the drive gives up to 0.144 Nm");
    const Motion motion = test::single(1000, 500, q);
    const AsBuilt robot = test::arm_with({lost("backlash", {{"friction_nm", friction}})}, "0 0 1");
    const Eigen::VectorXd got = deflection(robot, motion);
    const Eigen::VectorXd want =
        with_contacts(
            q, w, inertia, kWidth / 2, friction, [](double) { return 0.0; }, 2.0, 0.002)
            .head(1000);
    const Eigen::VectorXd quasi_static = twin(
        motion.q.row(0), [](int) { return kWidth / 2; }, [](int) { return 0; });
    const double off = std::sqrt((got - want).tail(900).squaredNorm() / 900) / kWidth;
    const double off_static = std::sqrt((quasi_static - want).tail(900).squaredNorm() / 900) / kWidth;
    RecordProperty("off_" + std::to_string(friction),
                   std::to_string(off) + " static " + std::to_string(off_static));
    EXPECT_LT(off, 0.02);
    if (friction < 0.1) {
      EXPECT_GT(off_static, 5 * off);
    }
  }
}

}  // namespace
}  // namespace ballbar

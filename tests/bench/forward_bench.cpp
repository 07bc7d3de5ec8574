// Time per pose of the kinematics. Usage: forward_bench URDF BASE TIP

#include <chrono>
#include <cstdio>
#include <fstream>
#include <random>
#include <sstream>
#include <vector>

#include "core/error.hpp"
#include "kinematics/inverse.hpp"
#include "kinematics/robot_model.hpp"

namespace {

/// [ns] per call, the best of five rounds: what the machine can do when nothing else runs.
template <typename Call>
double nanoseconds(const std::vector<std::vector<double>>& postures, Call call) {
  double best = 1e300;
  for (int round = 0; round < 5; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    for (const std::vector<double>& q : postures) call(q);
    const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - begin;
    best = std::min(best, took.count() / static_cast<double>(postures.size()));
  }
  return best;
}

int run(const char* path, const char* base, const char* tip) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  const ballbar::RobotModel model(text.str(), base, tip, ballbar::JointConvention::kSerial);
  std::mt19937_64 random(42);
  std::uniform_real_distribution<double> angle(-1.0, 1.0);
  std::vector<std::vector<double>> postures(20000,
                                            std::vector<double>(static_cast<std::size_t>(model.joints())));
  for (std::vector<double>& q : postures)
    for (double& each : q) each = angle(random);
  double sum = 0.0;  // printed, so that no call is optimised away
  const double forward =
      nanoseconds(postures, [&](const auto& q) { sum += model.forward(q).translation().x(); });
  const double jacobian = nanoseconds(postures, [&](const auto& q) { sum += model.jacobian(q)(0, 0); });
  const double columns =
      nanoseconds(postures, [&](const auto& q) { sum += model.chain().position_columns(q).alpha(0, 0); });
  const double torques = nanoseconds(
      postures, [&](const auto& q) { sum += gravity_torques(model.chain(), model.bodies(), q)(0); });
  postures.resize(200);
  const double near = nanoseconds(postures, [&](auto q) {
    const Eigen::Isometry3d pose = model.forward(q);
    for (double& each : q) each += 0.01;
    sum += inverse_near(model, pose, q).q[0];
  });
  postures.resize(20);
  const double all =
      nanoseconds(postures, [&](const auto& q) { sum += inverse(model, model.forward(q)).q[0]; });
  std::printf("forward          %8.0f ns per pose (budget 500)\n", forward);
  std::printf("jacobian         %8.0f ns\nposition columns %8.0f ns\ngravity torques  %8.0f ns\n", jacobian,
              columns, torques);
  std::printf("inverse, near    %8.0f ns\ninverse, all     %8.0f ns\n(checksum %g)\n", near, all, sum);
  return forward < 500 ? 0 : 1;
}

}  // namespace

int main(int count, char** words) {
  if (count != 4) {
    std::fprintf(stderr, "usage: forward_bench URDF BASE TIP\n");
    return 2;
  }
  try {
    return run(words[1], words[2], words[3]);
  } catch (const ballbar::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}

#include "gap/direction_classes.hpp"

#include <algorithm>
#include <cmath>

#include "numerics/evidence_search.hpp"

namespace ballbar {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

bool hangs_on_direction(const LeftOut& one) {
  return one.spec.effect == "joint_lost_motion" || one.spec.effect == "servo_lag" ||
         one.driver == "direction" || one.driver == "velocity";
}

/// How alike lost motion of the joints is, after zeros and set-up, by its root mean square: where exactly a
/// joint turns back would tell it apart, but there formulas are at their worst.
MatrixXd alike(const GapFitter& weighed) {
  std::vector<Observation> plain = weighed.observations();
  for (Observation& seen : plain) even_out(seen);
  const GapFitter fitter(weighed.model(), plain);
  const int joints = fitter.model().joints();
  GapFit none;
  none.state = fitter.model().start(fitter.observations());
  const Linearised at = fitter.linearise(none, false);
  MatrixXd columns(fitter.rows(), joints);
  for (int joint = 1; joint <= joints; ++joint)
    columns.col(joint - 1) =
        fitter.contribution(at, lost_motion_kinds(joint).front().with(VectorXd::Ones(1)));
  return resemblance(eliminate_baseline(at.residual, at.baseline, fitter.baseline_sd(GapPriors{}), columns,
                                        std::vector<int>(static_cast<std::size_t>(joints), 1)));
}

}  // namespace

void add_direction_classes(const GapFitter& fitter, Diagnosis& diagnosis) {
  if (std::none_of(diagnosis.left_out.begin(), diagnosis.left_out.end(), hangs_on_direction)) return;
  const MatrixXd like = alike(fitter);
  for (LeftOut& one : diagnosis.left_out) {
    if (!hangs_on_direction(one) || one.spec.joint < 1) continue;
    for (int joint = 1; joint <= fitter.model().joints(); ++joint) {
      const double cosine = std::abs(like(one.spec.joint - 1, joint - 1));
      const bool known = std::any_of(one.twins.begin(), one.twins.end(), [&](const Twin& twin) {
        return twin.effect == one.spec.effect && twin.joint == joint;
      });
      if (joint == one.spec.joint || known || cosine < kNotToldApart) continue;
      std::string label;
      if (one.spec.effect == "joint_lost_motion")
        label = lost_motion_kinds(joint).front().label();
      else if (one.spec.effect == "servo_lag")
        label = "servo_lag J" + std::to_string(joint);
      one.twins.push_back({one.spec.effect, joint, cosine, label,
                           "drive a circle in a plane tilted by 30 degrees, with the tool tilted: the joints "
                           "reverse at other angles"});
    }
  }
}

}  // namespace ballbar

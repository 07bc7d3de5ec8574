#include "gap/explain.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/units.hpp"
#include "gap/shape_freedom.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFormula = 0.01;  // of a size: formulas of effects are as good as that

std::string text_of(double value, std::chars_format format, int digits) {
  std::array<char, 400> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, format, digits);
  return {text.data(), end.ptr};
}

std::string number(double value, int digits = 3) {
  return text_of(value, std::chars_format::general, digits);
}

std::string um(double metres) { return text_of(metres * 1e6, std::chars_format::fixed, 1) + " um"; }

std::string joint_text(int joint) { return joint > 0 ? " of joint " + std::to_string(joint) : ""; }

/// The effect as a table of the configuration: parameters that are there, in the unit of their names.
EffectSpec spec_of(const Effect& effect) {
  EffectSpec spec;
  spec.effect = effect.kind->name;
  spec.joint = effect.joint;
  for (std::size_t i = 0; i < effect.values.size(); ++i) {
    const ParameterKind& parameter = effect.kind->parameters[i];
    if (effect.values[i] == parameter.absent && parameter.need != Need::kRequired) continue;
    spec.parameters[std::string(parameter.name)] = effect.values[i] / parameter.si;
  }
  if (effect.word >= 0)
    spec.words[std::string(effect.kind->word.name)] =
        effect.kind->word.allowed[static_cast<std::size_t>(effect.word)];
  return spec;
}

/// Values and standard deviations of the parameters that were free.
std::vector<NamedParameter> parameters_of(const NamedEffect& named, const MatrixXd& covariance) {
  const Candidate& candidate = named.candidate;
  const Effect effect = candidate.with(named.coefficients);
  // Beside the noise: what a formula that is a little wrong makes of its size.
  const VectorXd sd =
      (covariance.diagonal().array() + (kFormula * named.coefficients.array()).square()).sqrt();
  std::vector<NamedParameter> all;
  const auto add = [&](std::size_t slot, double si_sd) {
    const ParameterKind& parameter = effect.kind->parameters[slot];
    all.push_back({std::string(parameter.name), effect.values[slot] / parameter.si, si_sd / parameter.si});
  };
  switch (candidate.form) {
    case Candidate::Form::kSizes:
      for (std::size_t i = 0; i < candidate.slots.size(); ++i)
        add(candidate.slots[i], candidate.typical[i] * sd[static_cast<Index>(i)]);
      break;
    case Candidate::Form::kSine: {
      const double size = named.coefficients.norm();
      const Eigen::Vector2d along = named.coefficients / size, across(-along[1], along[0]);
      if (effect.kind->name == "transmission_error") add(0, candidate.rate_sd);
      add(candidate.slots[0],
          candidate.typical[0] * std::hypot(std::sqrt(along.dot(covariance * along)), kFormula * size));
      add(candidate.slots[1], std::sqrt(across.dot(covariance * across)) / size);
      break;
    }
    case Candidate::Form::kSquareRoot:
      add(candidate.slots[0],
          candidate.typical[0] * sd[0] / (2.0 * std::sqrt(std::max(named.coefficients[0], 1e-12))));
      break;
  }
  return all;
}

/// Which test would tell two effects apart (physics-gap.md 4).
std::string what_would_decide(const Candidate& a, const Candidate& b) {
  const auto is = [&](const char* name) {
    return a.effect.kind->name == name || b.effect.kind->name == name;
  };
  if (is("thermal_growth") || is("base_drift") || is("ball_slip") || is("gauge_jump"))
    return "drive the first circle again at the end, and once more an hour later: what grows with warmth "
           "goes on, what "
           "jumped stays";
  if (is("joint_compliance"))
    return "drive the same circle with and without payload: compliance grows with it";
  if (is("servo_lag") || is("path_smoothing"))
    return "drive the same circle at a third of the feed: lag shrinks with it, smoothing with its square";
  if (is("joint_lost_motion"))
    return "drive a circle in a plane tilted by 30 degrees, with the tool tilted: the joints reverse at "
           "other angles";
  return "drive a circle in a plane tilted by 30 degrees with the tool tilted, and one with another radius";
}

std::string sentence(const LeftOut& one, const Effect& effect) {
  std::string text = std::string(effect.kind->meaning) + joint_text(one.spec.joint) + ":";
  for (const NamedParameter& parameter : one.parameters)
    text += " " + parameter.name + " " + number(parameter.value) + " +- " + number(parameter.sd, 2) + ",";
  text.back() = ';';
  text += " it accounts for " + um(one.size) + " that zero offsets and set-up cannot take up";
  if (!one.twins.empty()) {
    text += "; not told apart from";
    for (const Twin& twin : one.twins) text += " " + twin.effect + joint_text(twin.joint) + ",";
    text.back() = '.';
  }
  return text;
}

int level_of(const EffectKind& kind) {
  if (kind.name == "joint_zero_offset") return 1;
  return kind.name == "link_geometry" || kind.name == "tool_offset" ? 2 : 3;
}

/// Zero offsets that set-up alone does not take up.
void add_zero_offsets(const GapFitter& fitter, const GapFit& fit, double least, Diagnosis& diagnosis) {
  std::vector<Observation> plain = fitter.observations();
  double places = 0.0;
  for (Observation& seen : plain) places += even_out(seen);
  const GapFitter even(fitter.model(), plain);
  const Linearised level = even.linearise(fit, false);
  GapPriors set_up;
  set_up.zero = 0.0;
  const Index joints = fit.state.zero.size();
  const MatrixXd contributions = level.baseline.leftCols(joints) * fit.state.zero.asDiagonal();
  const EvidenceProblem left =
      eliminate_baseline(VectorXd::Zero(even.rows()), level.baseline, even.baseline_sd(set_up), contributions,
                         std::vector<int>(static_cast<std::size_t>(joints), 1));
  for (Index j = 0; j < joints; ++j)
    diagnosis.zero_offsets.push_back(
        {"offset_deg", fit.state.zero[j] / kRadPerDeg, std::sqrt(fit.covariance(j, j)) / kRadPerDeg});
  diagnosis.mastering =
      mastering_of(fitter.model().model(), fit.state.zero, fit.covariance.topLeftCorner(joints, joints));
  for (Index j = 0; j < joints; ++j) {
    const double size = 1e-6 * std::sqrt(left.gram(j, j) / places);
    const double sd = std::sqrt(fit.covariance(j, j));
    if (size < least || std::abs(fit.state.zero[j]) < 3.0 * sd) continue;
    LeftOut one;
    one.spec.effect = "joint_zero_offset";
    one.spec.joint = static_cast<int>(j) + 1;
    const double degrees = fit.state.zero[j] / kRadPerDeg;
    one.spec.parameters["offset_deg"] = degrees;
    one.parameters.push_back({"offset_deg", degrees, sd / kRadPerDeg});
    one.level = 1;
    one.size = size;
    one.evidence = 0.5 * std::pow(fit.state.zero[j] / sd, 2);
    one.says = "joint " + std::to_string(j + 1) + " is mastered " + number(degrees) + " +- " +
               number(sd / kRadPerDeg, 2) + " deg off; it accounts for " + um(size);
    diagnosis.left_out.push_back(std::move(one));
  }
}

void add_curve(const GapFitter& fitter, const GapFit& fit, Diagnosis& diagnosis) {
  const Curve& curve = *fit.curve;
  const Linearised at = fitter.linearise(fit, false);
  double energy = 0.0, places = 0.0;
  for (std::size_t i = 0; i < at.tangents.size(); ++i) {
    Drive drive = at.tangents[i].drive();
    const VectorXd pushed = curve_columns(curve, at.tangents[i], drive) * fit.shape.tail(curve.width());
    energy += (pushed.array() - pushed.mean()).matrix().squaredNorm();
    places += static_cast<double>(pushed.size());
  }
  LeftOut one;
  one.spec.effect = "not_in_catalogue";
  one.spec.joint = curve.joint;
  one.driver = to_string(curve.driver);
  one.spec.words["driver"] = one.driver;
  one.size = std::sqrt(energy / places);
  one.says = "an error of joint " + std::to_string(curve.joint) + " that depends on its " + one.driver +
             " and that no effect of the catalogue explains; " + um(one.size);
  diagnosis.left_out.push_back(std::move(one));
  diagnosis.remainder.joint = curve.joint;
  diagnosis.remainder.structure = curve.driver == Driver::kVelocity ? "joint velocity"
                                  : curve.driver == Driver::kTorque ? "joint torque"
                                                                    : "joint angle";
}

void add_vibration(const Vibration& vibration, Diagnosis& diagnosis) {
  LeftOut one;
  one.spec.effect = "structural_vibration";
  const double hertz = vibration.frequency.value, size = vibration.amplitude.value;
  one.spec.parameters["frequency_hz"] = hertz;
  one.spec.parameters["amplitude_um"] = size * 1e6;
  one.parameters = {{"frequency_hz", hertz, vibration.frequency.sd.value_or(0.0)},
                    {"amplitude_um", size * 1e6, vibration.amplitude.sd.value_or(0.0) * 1e6}};
  one.size = size / std::sqrt(2.0);
  one.evidence = 0.5 * vibration.z * vibration.z;
  one.says = "arm or cell vibrates at " + number(hertz) + " Hz, " + um(size) +
             " along the bar, at every feed and with another phase in every lap: it counts as noise above";
  diagnosis.left_out.push_back(std::move(one));
}

/// The first lap's name, with the axis where a line may have been read along several.
std::string with_axis(const Observation& seen, char between) {
  const std::string& name = seen.runs.front();
  return seen.instrument.is_bar() ? name : name + between + seen.instrument.axis;
}

/// The ball, or how the optics of a line were aligned.
void add_set_up(const std::vector<Observation>& observations, int number, const Eigen::Vector3d& value,
                const Eigen::Vector3d& sd, Diagnosis& diagnosis) {
  const std::string name = "set_up" + std::to_string(number + 1) + "_";
  const auto add = [&](const std::string& what, double unit, Index i) {
    diagnosis.nuisance.push_back({name + what, value[i] * unit, sd[i] * unit});
  };
  const auto seen = std::find_if(observations.begin(), observations.end(),
                                 [&](const Observation& one) { return one.set_up == number; });
  if (seen != observations.end() && !seen->instrument.is_bar()) {
    add("offset_um", 1e6, 0);
    add("slope_urad", 2e6 / seen->instrument.length, 1);
    return;
  }
  add("ball_x_um", 1e6, 0);
  add("ball_y_um", 1e6, 1);
  add("ball_z_um", 1e6, 2);
}

void add_nuisance(const GapFitter& fitter, const GapFit& fit, Diagnosis& diagnosis) {
  const VectorXd sd = fit.covariance.diagonal().cwiseSqrt();
  const Layout layout(fit.state);
  for (std::size_t s = 0; s < fit.state.set_up.size(); ++s)
    add_set_up(fitter.observations(), static_cast<int>(s), fit.state.set_up[s],
               sd.segment<3>(layout.set_up + 3 * static_cast<Index>(s)), diagnosis);
  diagnosis.nuisance.push_back({"bar_zero_um", fit.state.bar_zero * 1e6, sd[layout.bar] * 1e6});
  diagnosis.nuisance.push_back({"bar_scale_ppm", fit.state.bar_scale * 1e6, sd[layout.bar + 1] * 1e6});
  for (std::size_t i = 0; i < fit.state.shift.size(); ++i)
    diagnosis.nuisance.push_back({"time_shift_" + with_axis(fitter.observations()[i], '_') + "_ms",
                                  fit.state.shift[i] * 1e3, sd[layout.shift + static_cast<Index>(i)] * 1e3});
}

/// Where each named effect of a joint shows most: the recording, and the arc about its largest value.
void locate(const GapFitter& fitter, const GapFit& fit, Diagnosis& diagnosis) {
  const Linearised at = fitter.linearise(fit, false);
  for (std::size_t e = 0; e < fit.named.size(); ++e) {
    const NamedEffect& named = fit.named[e];
    const Effect effect = named.candidate.with(named.coefficients);
    Located place;
    place.joint = effect.joint;
    double most = -1.0;
    for (std::size_t i = 0; i < at.tangents.size(); ++i) {
      const Observation& seen = fitter.observations()[i];
      Drive drive = at.tangents[i].drive();
      const VectorXd pushed = fitter.model().push(at.tangents[i], drive, effect);
      // Steps show where the value changes over a few places, all else where it is largest.
      VectorXd shown = (pushed.array() - pushed.mean()).abs();
      if (named.candidate.family == "lost motion") {
        const Index across = seen.at_rest ? 1 : 6;
        shown.setZero();
        for (Index k = across; k + across < pushed.size(); ++k)
          shown[k] = std::abs(pushed[k + across] - pushed[k - across]);
      }
      Index where = 0;
      const double largest = shown.maxCoeff(&where);
      if (largest <= most) continue;
      most = largest;
      Index from = where, to = where;
      while (from > 0 && shown[from - 1] > 0.5 * largest) --from;
      while (to + 1 < shown.size() && shown[to + 1] > 0.5 * largest) ++to;
      place.test = seen.test;
      place.direction = seen.direction;
      place.kind = seen.instrument.kind;
      place.axis = seen.instrument.axis;
      place.from = std::min(seen.place[from], seen.place[to]);
      place.to = std::max(seen.place[from], seen.place[to]);
    }
    const std::string_view name = effect.kind->name;
    place.size = most;
    place.what = name == "joint_lost_motion"                        ? "step at reversal"
                 : name == "transmission_error"                     ? "ripple in joint angle"
                 : name == "ball_slip" || name == "gauge_jump"      ? "jump in time"
                 : name == "thermal_growth" || name == "base_drift" ? "drift in time"
                 : place.kind == TestKind::kLine                    ? "smooth over the line"
                                                                    : "smooth over the circle";
    place.grows_with = name == "joint_compliance"                         ? "payload"
                       : name == "servo_lag" || name == "path_smoothing"  ? "speed"
                       : name == "thermal_growth" || name == "base_drift" ? "time"
                                                                          : "";
    const bool line = place.kind == TestKind::kLine;
    const double unit = line ? kMetresPerMm : kRadPerDeg;
    place.says = place.test + (place.direction > 0 ? "+1" : "-1") +
                 (line ? std::string(" ") + place.axis : "") + ": " + place.what + joint_text(place.joint) +
                 ", " + um(place.size) + " between " + number(place.from / unit) + " and " +
                 number(place.to / unit) + (line ? " mm" : " deg") +
                 (place.grows_with.empty() ? "" : "; it grows with " + place.grows_with);
    diagnosis.located.push_back(std::move(place));
  }
}

}  // namespace

std::vector<NamedParameter> mastering_of(const RobotModel& model, const VectorXd& zero,
                                         const MatrixXd& covariance) {
  const Index joints = zero.size();
  MatrixXd turn = MatrixXd::Identity(joints, joints);  // chain to controller; both are linear in the angles
  for (Index j = 0; j < joints; ++j) model.from_chain({turn.col(j).data(), static_cast<std::size_t>(joints)});
  const VectorXd value = turn * zero;
  const MatrixXd spread = turn * covariance * turn.transpose();
  std::vector<NamedParameter> all;
  for (Index j = 0; j < joints; ++j)
    all.push_back(
        {"j" + std::to_string(j + 1) + "_deg", value[j] / kRadPerDeg, std::sqrt(spread(j, j)) / kRadPerDeg});
  return all;
}

void explain(const GapFitter& fitter, const GapFit& fit, const Weights& weights,
             const std::vector<Candidate>& candidates, const std::optional<Vibration>& vibration,
             double least, Diagnosis& diagnosis) {
  Index at = Layout(fit.state).effects;
  for (std::size_t i = 0; i < fit.named.size(); ++i) {
    const NamedEffect& named = fit.named[i];
    const Index width = named.candidate.width();
    const Effect effect = named.candidate.with(named.coefficients);
    LeftOut one;
    one.spec = spec_of(effect);
    one.level = level_of(*effect.kind);
    one.size = weights.size[i];
    one.evidence = weights.evidence[i];
    one.parameters = parameters_of(named, fit.covariance.block(at, at, width, width));
    for (const Weighed& twin : weights.twins[i]) {
      const Candidate& other = candidates[twin.candidate];
      one.twins.push_back({std::string(other.effect.kind->name), other.effect.joint, twin.resemblance,
                           other.label(), what_would_decide(named.candidate, other)});
    }
    one.says = sentence(one, effect);
    diagnosis.left_out.push_back(std::move(one));
    at += width;
  }
  if (fit.curve) add_curve(fitter, fit, diagnosis);
  if (vibration) add_vibration(*vibration, diagnosis);
  add_zero_offsets(fitter, fit, least, diagnosis);
  double total = 0.0;
  for (const LeftOut& one : diagnosis.left_out) total += one.size * one.size;
  for (LeftOut& one : diagnosis.left_out) one.share = total > 0.0 ? one.size * one.size / total : 0.0;
  std::stable_sort(diagnosis.left_out.begin(), diagnosis.left_out.end(),
                   [](const LeftOut& a, const LeftOut& b) { return a.share > b.share; });
  add_nuisance(fitter, fit, diagnosis);
  locate(fitter, fit, diagnosis);
}

}  // namespace ballbar

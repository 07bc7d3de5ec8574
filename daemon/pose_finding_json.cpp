#include "daemon/pose_finding_json.hpp"

#include <cmath>
#include <cstdio>

#include "core/units.hpp"

namespace ballbar {

const char* pose_effect_name(const PoseTerm& term, const PoseDiagnosis& d) {
  switch (term.effect) {
    case PoseEffect::kZeroOffset:
      return "joint_zero_offset";
    case PoseEffect::kLinkA:
    case PoseEffect::kLinkD:
    case PoseEffect::kLinkAlpha:
    case PoseEffect::kLinkBeta:
      return "link_geometry";
    case PoseEffect::kCompliance:
      return "joint_compliance";
    case PoseEffect::kEccentricity:
      return "joint_eccentricity";
    case PoseEffect::kRipple:
    case PoseEffect::kRippleRate:
      return "transmission_error";
    case PoseEffect::kLostMotion:
    case PoseEffect::kLostMotionMove:
      return "joint_lost_motion";
    case PoseEffect::kReadbackCommand:
      return d.reading_step > 0.0 && !d.command_follows_move ? "joint_readback_rounding"
                                                             : "joint_readback_lag";
    case PoseEffect::kReadbackMove:
    case PoseEffect::kReadbackTime:
      return "joint_readback_lag";
    case PoseEffect::kJump:
      return "gauge_jump";
    case PoseEffect::kDrift:
      return "base_drift";
    case PoseEffect::kGrowth:
      return "thermal_growth";
    case PoseEffect::kAngleCurve:
    case PoseEffect::kTimeCurve:
      return "not_in_catalogue";
  }
  return "";
}

const char* pose_parameter_name(PoseEffect effect) {
  switch (effect) {
    case PoseEffect::kZeroOffset:
      return "offset_deg";
    case PoseEffect::kLinkA:
      return "a_mm";
    case PoseEffect::kLinkD:
      return "d_mm";
    case PoseEffect::kLinkAlpha:
      return "alpha_deg";
    case PoseEffect::kLinkBeta:
      return "beta_deg";
    default:
      return "";
  }
}

std::string joint_in_words(int joint) { return joint > 0 ? "joint " + std::to_string(joint) : "all joints"; }

namespace {

constexpr double kSecondsPerHour = 3600.0, kSecondsPerMinute = 60.0;

std::string figure(double value, const char* format = "%.3g") {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

Json parameter(const char* name, double value, double sd) {
  return {{"name", name}, {"value", value}, {"sd", sd}};
}
Json parameter(const char* name, double value) { return {{"name", name}, {"value", value}, {"sd", nullptr}}; }

/// Amplitude and phase of value[0] sin + value[1] cos.
Json wave(const PoseFinding& f) {
  const double s = f.values[0], c = f.values[1], amplitude = std::hypot(s, c);
  const double sd = std::hypot(s * f.sd[0], c * f.sd[1]) / amplitude;
  const double phase_sd = std::hypot(c * f.sd[0], s * f.sd[1]) / (amplitude * amplitude);
  Json all = Json::array();
  if (f.term.effect == PoseEffect::kRipple)  // D. Rife, R. Boorstyn, IEEE Trans. Inf. Theory 20 (1974) 591
    all.push_back(
        parameter("cycles_per_turn", f.term.setting, std::sqrt(12.0) * sd / amplitude / f.term.setting2));
  all.push_back(parameter("amplitude_deg", to_deg(amplitude), to_deg(sd)));
  all.push_back(parameter("phase_deg", to_deg(std::atan2(c, s)), to_deg(phase_sd)));
  return all;
}

Json jump(const PoseFinding& f) {
  Json all = Json::array();
  if (f.values.size() == 1) {
    all.push_back(parameter("jump_um", to_um(f.values[0]), to_um(f.sd[0])));
  } else {
    const double size = std::hypot(f.values[0], f.values[1], f.values[2]);
    double variance = 0.0;
    for (std::size_t k = 0; k < 3; ++k) variance += std::pow(f.values[k] / size * f.sd[k], 2);
    all.push_back(parameter("jump_um", to_um(size), to_um(std::sqrt(variance))));
    const char* names[] = {"x_um", "y_um", "z_um"};
    for (std::size_t k = 0; k < 3; ++k)
      all.push_back(parameter(names[k], to_um(f.values[k]), to_um(f.sd[k])));
  }
  all.push_back(parameter("row", f.term.setting));
  return all;
}

Json readback(const PoseFinding& f, const PoseDiagnosis& d, const std::string& effect) {
  const double value = f.values[0], sd = f.sd[0];
  if (f.term.effect == PoseEffect::kReadbackTime) return {parameter("lag_ms", to_ms(value), to_ms(sd))};
  if (f.term.effect == PoseEffect::kReadbackMove)  // angle - reading = g (reading - reading before)
    return {parameter("fraction_of_move", value / (1.0 + value), sd / ((1.0 + value) * (1.0 + value)))};
  if (effect == "joint_readback_rounding") return {parameter("step_deg", to_deg(d.reading_step))};
  return {parameter("fraction_of_move", value * d.command_on_move, sd * std::abs(d.command_on_move))};
}

Json parameters(const PoseFinding& f, const PoseDiagnosis& d) {
  const double value = f.values[0], sd = f.sd[0];
  switch (f.term.effect) {
    case PoseEffect::kZeroOffset:
    case PoseEffect::kLinkAlpha:
    case PoseEffect::kLinkBeta:
      return {parameter(pose_parameter_name(f.term.effect), to_deg(value), to_deg(sd))};
    case PoseEffect::kLinkA:
    case PoseEffect::kLinkD:
      return {parameter(pose_parameter_name(f.term.effect), to_mm(value), to_mm(sd))};
    case PoseEffect::kCompliance:
      return {parameter("compliance_rad_per_nm", value, sd)};
    case PoseEffect::kEccentricity:
    case PoseEffect::kRipple:
      return wave(f);
    case PoseEffect::kLostMotion:
    case PoseEffect::kLostMotionMove:
      return {parameter("width_deg", to_deg(std::abs(value)), to_deg(sd))};
    case PoseEffect::kReadbackMove:
    case PoseEffect::kReadbackCommand:
    case PoseEffect::kReadbackTime:
      return readback(f, d, pose_effect_name(f.term, d));
    case PoseEffect::kJump:
      return jump(f);
    case PoseEffect::kDrift: {
      const double per_hour = kSecondsPerHour / kMetresPerUm;
      return {parameter("x_um", f.values[0] * per_hour, f.sd[0] * per_hour),
              parameter("y_um", f.values[1] * per_hour, f.sd[1] * per_hour),
              parameter("z_um", f.values[2] * per_hour, f.sd[2] * per_hour)};
    }
    case PoseEffect::kGrowth:
      return {parameter("strain_ppm", value * 1e6, sd * 1e6),
              parameter("time_constant_min", f.term.setting / kSecondsPerMinute)};
    case PoseEffect::kRippleRate:
    case PoseEffect::kAngleCurve:
    case PoseEffect::kTimeCurve:
      return Json::array();
  }
  return Json::array();
}

Json curve_json(const PoseFinding& f) {
  Json curve = Json::array();
  if (f.term.effect == PoseEffect::kAngleCurve)
    for (int k = 0; k < kAngleKnots; ++k)
      curve.push_back(
          {{"angle_deg", to_deg(f.term.setting + (f.term.setting2 - f.term.setting) * k / (kAngleKnots - 1))},
           {"error_deg", to_deg(f.values[static_cast<std::size_t>(k)])}});
  else
    for (std::size_t k = 0; k < static_cast<std::size_t>(kTimeKnots); ++k)
      curve.push_back({{"place", static_cast<double>(k) / (kTimeKnots - 1)},
                       {"x_um", to_um(f.values[3 * k])},
                       {"y_um", to_um(f.values[3 * k + 1])},
                       {"z_um", to_um(f.values[3 * k + 2])}});
  return curve;
}

/// Value and unit of the first parameter.
std::string said(const Json& entry) {
  const Json& all = entry["parameters"];
  if (all.empty()) return "";
  std::string text;
  for (const Json& p : all) {
    if (p["name"] == "phase_deg" || p["name"] == "cycles_per_turn") continue;
    text = p["name"].get<std::string>() + " " + figure(p["value"].get<double>(), "%.4g");
    break;
  }
  return text;
}

std::string sentence(const PoseFinding& f, const Json& entry) {
  const std::string joint = joint_in_words(f.term.joint), size = said(entry);
  switch (f.term.effect) {
    case PoseEffect::kZeroOffset:
      return "the zero of " + joint + " is off: " + size;
    case PoseEffect::kLinkA:
    case PoseEffect::kLinkD:
    case PoseEffect::kLinkAlpha:
    case PoseEffect::kLinkBeta:
      return "row " + std::to_string(f.term.joint) + " of the DH table differs: " + size;
    case PoseEffect::kCompliance:
      return joint + " gives way under gravity: " + size + " with the masses of the URDF" +
             (f.values[0] < 0.0
                  ? "; a negative figure says that those or the counterbalance are not as it has them"
                  : "");
    case PoseEffect::kEccentricity:
      return joint + " has an error once per turn: " + size;
    case PoseEffect::kRipple:
      return joint + " has an error " + figure(f.term.setting, "%.2f") + " times per turn: " + size;
    case PoseEffect::kLostMotion:
      return joint + " loses motion when the poses are approached from the other side: " + size;
    case PoseEffect::kLostMotionMove:
      return joint + " stands differently by the side from which it came: " + size;
    case PoseEffect::kReadbackMove:
      return "the reading of " + joint + " lacks a part of the last move: " + size;
    case PoseEffect::kReadbackTime:
      return "the reading of " + joint + (f.values[0] < 0.0 ? " is younger" : " is older") +
             " than the measurement: " + size;
    case PoseEffect::kReadbackCommand:
      return entry["effect"] == "joint_readback_rounding"
                 ? "the reading of " + joint + " is rounded: " + size + "; the command is nearer to the truth"
                 : "the reading of " + joint + " lags behind the command: " + size;
    case PoseEffect::kJump:
      return "the instrument, or the robot's base, jumped at row " +
             std::to_string(static_cast<int>(f.term.setting)) + ": " + size;
    case PoseEffect::kDrift:
      return "the robot's base, or the instrument, drifts (um per hour)";
    case PoseEffect::kGrowth:
      return "links grow as the robot warms: " + size;
    case PoseEffect::kAngleCurve:
      return joint +
             " has an error that depends on its angle and is none of the catalogue's; never extrapolate it";
    case PoseEffect::kRippleRate:
      return "";
    case PoseEffect::kTimeCurve:
      return "the readings move in time in a way that is none of the catalogue's";
  }
  return "";
}

const char* to_tell_apart(const PoseTerm& one, const PoseTerm& other) {
  const auto is = [&](PoseEffect effect) { return one.effect == effect || other.effect == effect; };
  if (is(PoseEffect::kCompliance)) return "measure the same poses with another payload";
  if (is(PoseEffect::kLostMotion) || is(PoseEffect::kLostMotionMove))
    return "approach every pose from both sides, and note it in a column direction";
  if (is(PoseEffect::kReadbackMove) || is(PoseEffect::kReadbackCommand) || is(PoseEffect::kReadbackTime))
    return "repeat poses after a long and after a short move";
  if (is(PoseEffect::kDrift) || is(PoseEffect::kGrowth) || is(PoseEffect::kJump) ||
      is(PoseEffect::kTimeCurve))
    return "come back to the first poses at the end, and in between";
  return "measure a second point on the tool, and poses that turn these joints further";
}

}  // namespace

Json pose_finding_json(const PoseFinding& f, const PoseDiagnosis& d) {
  Json entry{{"effect", pose_effect_name(f.term, d)}};
  if (f.term.effect == PoseEffect::kLostMotion || f.term.effect == PoseEffect::kLostMotionMove)
    entry["kind"] = "unresolved";
  if (f.term.effect == PoseEffect::kAngleCurve) entry["driver"] = "angle";
  if (f.term.effect == PoseEffect::kTimeCurve) entry["driver"] = "time";
  entry["joint"] = f.term.joint;
  entry["level"] = f.level;
  entry["share"] = f.share;
  entry["evidence"] = f.evidence;
  entry["size_um"] = to_um(f.contribution);
  entry["parameters"] = parameters(f, d);
  if (entry.contains("driver")) entry["curve"] = curve_json(f);
  entry["cannot_be_told_from"] = Json::array();
  for (const PoseTerm& twin : f.cannot_be_told_from) {
    Json other{{"effect", pose_effect_name(twin, d)}, {"joint", twin.joint}};
    if (*pose_parameter_name(twin.effect) != '\0') other["parameter"] = pose_parameter_name(twin.effect);
    other["to_tell_apart"] = to_tell_apart(f.term, twin);
    entry["cannot_be_told_from"].push_back(other);
  }
  entry["says"] = sentence(f, entry);
  return entry;
}

}  // namespace ballbar

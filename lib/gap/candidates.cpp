#include "gap/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kParallel = 1e-9;
constexpr double kAnyLoad = std::numeric_limits<double>::infinity();
constexpr double kStep = 0.02;  // of a size, for the slope of a curved pattern

/// Words of joint_lost_motion.
enum LostMotion { kBacklash = 0, kFrictionWindup = 1, kLoadFriction = 2 };

Candidate of(const char* name, int joint, std::vector<std::size_t> slots) {
  Candidate candidate;
  candidate.effect.kind = find_effect_kind(name);
  candidate.effect.joint = joint;
  for (const ParameterKind& parameter : candidate.effect.kind->parameters)
    candidate.effect.values.push_back(parameter.absent);
  candidate.slots = std::move(slots);
  for (const std::size_t slot : candidate.slots) {
    const ParameterKind& parameter = candidate.effect.kind->parameters[slot];
    candidate.typical.push_back(parameter.typical * parameter.si);
  }
  return candidate;
}

Candidate sine(const char* name, int joint, std::size_t amplitude, std::size_t phase) {
  Candidate candidate = of(name, joint, {amplitude, phase});
  candidate.form = Candidate::Form::kSine;
  candidate.typical.resize(1);
  return candidate;
}

Candidate lost_motion(int joint, int word, double friction) {
  Candidate candidate = of("joint_lost_motion", joint, {0});
  candidate.effect.word = word;
  candidate.effect.values[1] = friction;
  candidate.positive = true;
  candidate.curved = true;
  candidate.family = "lost motion";
  return candidate;
}

void add_joint(const GapModel& model, int joint, std::vector<Candidate>& all) {
  if (model.loads_known()) {
    all.push_back(of("joint_compliance", joint, {0}));
    all.back().typical[0] = joint <= 3 ? 4e-5 : 2e-4;
    all.back().positive = true;
    for (Candidate& kind : lost_motion_kinds(joint))
      if (kind.effect.word != kBacklash || kind.effect.values[1] == 0.1 || kind.effect.values[1] == 0.6)
        all.push_back(std::move(kind));
  } else {
    all.push_back(lost_motion(joint, kFrictionWindup, kAnyLoad));
  }
  all.push_back(of("servo_lag", joint, {0}));
  all.back().positive = true;
  all.back().curved = true;
  all.push_back(sine("joint_eccentricity", joint, 0, 1));
  const auto index = static_cast<std::size_t>(joint - 1);
  const std::vector<double>& ratio = model.spec().gear_ratio;
  if (index < ratio.size() && ratio[index] > 0.0)
    for (const double times : {1.0, 2.0}) all.push_back(ripple(joint, times * ratio[index]));
}

/// Rows of the table from the second on: the first is where the base stands, which the ball's place takes up.
void add_geometry(const GapModel& model, std::vector<Candidate>& all) {
  const std::vector<DhRow>& rows = model.model().chain().rows();
  for (std::size_t row = 1; row < rows.size(); ++row) {
    const bool parallel = std::abs(std::sin(rows[row].alpha)) < kParallel;
    for (const std::size_t slot : {0u, 1u, 2u, 3u}) {
      if (slot == 1 && parallel) continue;               // the same as d of the row before
      if (slot == 3 && !parallel) continue;              // the same as a zero offset or a length
      if (slot < 2 && row + 1 == rows.size()) continue;  // the same as a tool offset
      all.push_back(of("link_geometry", static_cast<int>(row) + 1, {slot}));
    }
  }
  for (const std::size_t slot : {0u, 1u, 2u}) all.push_back(of("tool_offset", 0, {slot}));
}

/// [us]
double between(const Observation& before, const Observation& after) {
  return 0.5 * static_cast<double>(before.end_us + after.begin_us);
}

/// Between which circles the bar may have changed, and between which of one ball that may have moved.
void add_moments(const std::vector<Observation>& observations, std::vector<Candidate>& all) {
  std::vector<const Observation*> circles;
  for (const Observation& seen : observations)
    if (seen.instrument.is_bar()) circles.push_back(&seen);
  for (std::size_t i = 1; i < circles.size(); ++i) {
    const Observation& before = *circles[i - 1];
    const Observation& after = *circles[i];
    if (before.series != after.series) continue;
    all.push_back(of("gauge_jump", 0, {0}));
    all.back().effect.values[1] = between(before, after);
    all.back().family = "gauge jump";
  }
  for (std::size_t i = 0; i < circles.size(); ++i) {
    const Observation& before = *circles[i];
    const auto after = std::find_if(circles.begin() + static_cast<std::ptrdiff_t>(i) + 1, circles.end(),
                                    [&](const Observation* o) { return o->set_up == before.set_up; });
    if (after == circles.end()) continue;
    Candidate slip = of("ball_slip", 0, {0, 1, 2});
    slip.effect.values[3] = between(before, **after);
    for (std::size_t axis = 0; axis < 3; ++axis)
      slip.effect.values[4 + axis] = before.instrument.origin[static_cast<Index>(axis)];
    slip.family = "ball slip";
    all.push_back(std::move(slip));
  }
}

double longest_series(const std::vector<Observation>& observations) {
  double longest = 0.0;
  for (const Observation& seen : observations) longest = std::max(longest, seen.conditions.series_time);
  return longest;
}

}  // namespace

Effect Candidate::with(const VectorXd& c) const {
  Effect changed = effect;
  switch (form) {
    case Form::kSizes:
      for (std::size_t i = 0; i < slots.size(); ++i)
        changed.values[slots[i]] = c[static_cast<Index>(i)] * typical[i];
      break;
    case Form::kSine:
      changed.values[slots[0]] = typical[0] * std::hypot(c[0], c[1]);
      changed.values[slots[1]] = std::atan2(c[1], c[0]);
      break;
    case Form::kSquareRoot:
      changed.values[slots[0]] = typical[0] * std::sqrt(std::max(0.0, c[0]));
      break;
  }
  return changed;
}

std::string Candidate::label() const {
  std::string text(effect.kind->name);
  if (effect.joint > 0) text += " J" + std::to_string(effect.joint);
  if (effect.word >= 0)
    text += " " + std::string(effect.kind->word.allowed[static_cast<std::size_t>(effect.word)]);
  if (form == Form::kSine && slots[0] == 1) text += " " + std::to_string(std::lround(effect.values[0])) + "x";
  if (effect.kind->name == "link_geometry" || effect.kind->name == "tool_offset")
    text += " " + std::string(effect.kind->parameters[slots[0]].name);
  return text;
}

Candidate ripple(int joint, double cycles) {
  Candidate candidate = sine("transmission_error", joint, 1, 2);
  candidate.effect.values[0] = cycles;
  return candidate;
}

std::vector<Candidate> lost_motion_kinds(int joint) {
  std::vector<Candidate> kinds{lost_motion(joint, kFrictionWindup, kAnyLoad),
                               lost_motion(joint, kLoadFriction, joint <= 3 ? 10.0 : 1.0)};
  for (const double friction : {0.06, 0.1, 0.17, 0.28, 0.42, 0.6, 0.85, 1.2, 1.7, 2.5, 3.5})
    kinds.push_back(lost_motion(joint, kBacklash, friction));
  return kinds;
}

std::vector<Candidate> candidates_for(const GapModel& model, const std::vector<Observation>& observations) {
  std::vector<Candidate> all;
  for (int joint = 1; joint <= model.joints(); ++joint) add_joint(model, joint, all);
  add_geometry(model, all);
  all.push_back(of("path_smoothing", 0, {0}));
  all.back().form = Candidate::Form::kSquareRoot;
  all.back().positive = true;
  all.back().curved = true;
  if (longest_series(observations) > 300.0) {
    for (int link = 2; link <= std::min(4, model.joints()); ++link) {
      all.push_back(of("thermal_growth", link, {0}));
      all.back().effect.values[1] = 35.0 * 60.0;
    }
    all.push_back(of("base_drift", 0, {0, 1, 2}));
  }
  add_moments(observations, all);
  return all;
}

Candidate with_free_shape(const Candidate& candidate) {
  Candidate free = candidate;
  const bool gap = free.family == "lost motion" && free.effect.word == kBacklash;
  const bool warming = free.effect.kind->name == "thermal_growth";
  if ((!gap && !warming) || free.slots.size() != 1) return free;
  free.slots = {0, 1};
  free.typical = {free.typical[0], free.effect.values[1]};
  free.curved = true;
  return free;
}

MatrixXd columns_of(const GapModel& model, const Tangent& at, Drive& drive, const Candidate& candidate,
                    const VectorXd& now, Slope slope) {
  const Index width = candidate.width();
  MatrixXd columns(at.time.size(), width);
  if (candidate.curved && now.size() == width && std::abs(now[0]) > 2.0 * kStep) {
    if (slope == Slope::kChord) return model.push(at, drive, candidate.with(now)) / now[0];
    for (Index i = 0; i < width; ++i) {
      VectorXd more = now, less = now;
      more[i] *= 1.0 + kStep;
      less[i] *= 1.0 - kStep;
      columns.col(i) =
          (model.push(at, drive, candidate.with(more)) - model.push(at, drive, candidate.with(less))) /
          (more[i] - less[i]);
    }
    return columns;
  }
  for (Index i = 0; i < width; ++i)
    columns.col(i) = model.push(at, drive, candidate.with(VectorXd::Unit(width, i)));
  return columns;
}

}  // namespace ballbar

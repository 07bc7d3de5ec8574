#include "physics/catalogue.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "core/error.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

using Names = std::vector<std::string_view>;

/// How many letters have to be put in, left out or changed. Source: V. I. Levenshtein, 1966.
std::size_t letters_apart(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t corner = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = corner + (a[i - 1] == b[j - 1] ? 0 : 1);
      corner = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
    }
  }
  return row.back();
}

std::string listed(const Names& names) {
  std::string text;
  for (const std::string_view name : names) text += (text.empty() ? "" : ", ") + std::string(name);
  return text;
}

/// Ends a complaint: the name that was probably meant, else all that are known.
std::string advice(std::string_view given, const Names& known) {
  const auto nearest = std::min_element(known.begin(), known.end(), [&](auto a, auto b) {
    return letters_apart(given, a) < letters_apart(given, b);
  });
  if (nearest != known.end() && letters_apart(given, *nearest) <= 1 + nearest->size() / 4)
    return "; did you mean '" + std::string(*nearest) + "'?";
  return "; known are: " + listed(known);
}

std::string quoted(std::string_view text) { return "'" + std::string(text) + "'"; }

std::string shown(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

Names keys(const EffectKind& kind) {
  Names names;
  for (const ParameterKind& parameter : kind.parameters) names.push_back(parameter.name);
  if (!kind.word.name.empty()) names.push_back(kind.word.name);
  return names;
}

using Fault = std::optional<EffectFault>;

Fault joint_fault(const EffectSpec& spec, const EffectKind& kind, int joints) {
  if (kind.joint == JointUse::kNone && spec.joint != 0)
    return EffectFault{"joint", quoted(kind.name) + " belongs to no joint; leave 'joint' out"};
  if (kind.joint == JointUse::kOne && spec.joint == 0)
    return EffectFault{"joint", quoted(kind.name) + " needs 'joint', counted from 1 at the base"};
  if (spec.joint < 0 || spec.joint > joints)
    return EffectFault{"joint", "'joint' = " + std::to_string(spec.joint) +
                                    ", but the robot's joints are 1 to " + std::to_string(joints)};
  if (kind.joint == JointUse::kLinkOrAll && spec.joint >= joints)
    return EffectFault{"joint", "'joint' = " + std::to_string(spec.joint) + " moves the tool only; " +
                                    quoted(kind.name) + " takes 1 to " + std::to_string(joints - 1) +
                                    ", or 0 for all links"};
  return {};
}

Fault number_fault(const EffectKind& kind, const std::string& name, double value) {
  if (name == kind.word.name)
    return EffectFault{name, quoted(name) + " is a word: " + listed(kind.word.allowed)};
  for (const ParameterKind& parameter : kind.parameters) {
    if (parameter.name != name) continue;
    if (std::isfinite(value) && value >= parameter.least && value <= parameter.most) return {};
    return EffectFault{name, quoted(name) + " = " + shown(value) + " is outside " + shown(parameter.least) +
                                 " .. " + shown(parameter.most)};
  }
  return EffectFault{name,
                     quoted(kind.name) + " has no parameter " + quoted(name) + advice(name, keys(kind))};
}

Fault word_fault(const EffectKind& kind, const std::string& name, const std::string& word) {
  if (name == kind.word.name) {
    const Names& allowed = kind.word.allowed;
    if (std::find(allowed.begin(), allowed.end(), word) != allowed.end()) return {};
    return EffectFault{name, quoted(name) + " cannot be \"" + word + "\"" + advice(word, allowed)};
  }
  for (const ParameterKind& parameter : kind.parameters)
    if (parameter.name == name) return EffectFault{name, quoted(name) + " must be a number"};
  return EffectFault{name,
                     quoted(kind.name) + " has no parameter " + quoted(name) + advice(name, keys(kind))};
}

Fault missing_fault(const EffectSpec& spec, const EffectKind& kind) {
  if (kind.word.required && !spec.words.contains(std::string(kind.word.name)))
    return EffectFault{
        "", quoted(kind.name) + " needs " + quoted(kind.word.name) + ": " + listed(kind.word.allowed)};
  Names some, one;
  std::size_t of_some = 0, of_one = 0;
  for (const ParameterKind& parameter : kind.parameters) {
    const bool given = spec.parameters.contains(std::string(parameter.name));
    if (parameter.need == Need::kRequired && !given)
      return EffectFault{"", quoted(kind.name) + " needs " + quoted(parameter.name)};
    if (parameter.need == Need::kSomeOf) some.push_back(parameter.name);
    if (parameter.need == Need::kOneOf) one.push_back(parameter.name);
    of_some += parameter.need == Need::kSomeOf && given ? 1 : 0;
    of_one += parameter.need == Need::kOneOf && given ? 1 : 0;
  }
  if (!some.empty() && of_some == 0)
    return EffectFault{"", quoted(kind.name) + " needs at least one of: " + listed(some)};
  if (!one.empty() && of_one != 1)
    return EffectFault{"", quoted(kind.name) + " needs exactly one of: " + listed(one)};
  return {};
}

}  // namespace

const std::vector<EffectKind>& effect_catalogue() {
  static const std::vector<EffectKind> kinds{joint_zero_offset(),
                                             link_geometry(),
                                             tool_offset(),
                                             joint_compliance(),
                                             joint_lost_motion(),
                                             path_smoothing(),
                                             servo_lag(),
                                             transmission_error(),
                                             joint_eccentricity(),
                                             thermal_growth(),
                                             structural_vibration(),
                                             joint_readback_lag(),
                                             joint_readback_rounding(),
                                             gauge_jump(),
                                             ball_slip(),
                                             base_drift(),
                                             not_in_catalogue()};
  return kinds;
}

const EffectKind* find_effect_kind(std::string_view name) {
  for (const EffectKind& kind : effect_catalogue())
    if (kind.name == name) return &kind;
  return nullptr;
}

std::optional<EffectFault> effect_fault(const EffectSpec& spec, int joints) {
  const EffectKind* kind = find_effect_kind(spec.effect);
  if (!kind) {
    Names names;
    for (const EffectKind& known : effect_catalogue())
      if (known.forward) names.push_back(known.name);
    return EffectFault{"effect", "unknown effect " + quoted(spec.effect) + advice(spec.effect, names)};
  }
  if (!kind->forward)
    return EffectFault{"effect", quoted(kind->name) +
                                     " is a finding without a model: nothing can be predicted from it; take "
                                     "the table out and keep the finding with the diagnosis"};
  if (Fault fault = joint_fault(spec, *kind, joints)) return fault;
  for (const auto& [name, value] : spec.parameters)
    if (Fault fault = number_fault(*kind, name, value)) return fault;
  for (const auto& [name, word] : spec.words)
    if (Fault fault = word_fault(*kind, name, word)) return fault;
  return missing_fault(spec, *kind);
}

Effect make_effect(const EffectSpec& spec, int joints) {
  if (const Fault fault = effect_fault(spec, joints))
    throw Error(Cause::kInput, "effect " + quoted(spec.effect) +
                                   (spec.joint ? " of joint " + std::to_string(spec.joint) : "") + ": " +
                                   fault->what);
  Effect effect{.kind = find_effect_kind(spec.effect), .joint = spec.joint};
  for (const ParameterKind& parameter : effect.kind->parameters) {
    const auto given = spec.parameters.find(std::string(parameter.name));
    effect.values.push_back(given == spec.parameters.end() ? parameter.absent : given->second * parameter.si);
  }
  const auto word = spec.words.find(std::string(effect.kind->word.name));
  if (word != spec.words.end()) {
    const Names& allowed = effect.kind->word.allowed;
    effect.word = static_cast<int>(std::find(allowed.begin(), allowed.end(), word->second) - allowed.begin());
  }
  return effect;
}

}  // namespace ballbar

#include "pipeline/circle_test.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/units.hpp"
#include "metrology/signatures.hpp"

namespace ballbar {
namespace {

/// Fields of CircleFigures and CirclePair by their published names; of several that share a name the first.
constexpr std::array<std::pair<const char*, const char*>, 10> kPublished{{
    {"circular_error_mz", "circular_error_um"},
    {"radius_deviation", "mean_radius_deviation_um, eccentricity, ovality, harmonics, circular_deviation_um"},
    {"radial_max_ls", "radial_max_um"},
    {"radial_min_ls", "radial_min_um"},
    {"lsc", "roundness_lsc_um"},
    {"mzc", "roundness_mzc_um"},
    {"mic", "roundness_mic_um"},
    {"mcc", "roundness_mcc_um"},
    {"circular_error_b", "circular_error_bidirectional_um"},
    {"radial_error_d", "mean_bidirectional_radial_error_um"},
}};

std::string published(const std::string& figure) {
  const auto* const found = std::find_if(kPublished.begin(), kPublished.end(),
                                         [&](const auto& entry) { return entry.first == figure; });
  if (found != kPublished.end()) return found->second;
  return figure == "hysteresis" ? "hysteresis_um" : "";
}

/// "not defined on this arc: a, b (why); c (why)".
std::string not_defined_text(const std::vector<NotDefined>& list) {
  std::vector<std::pair<std::string, std::string>> by_reason;
  for (const NotDefined& each : list) {
    const std::string name = published(each.figure);
    if (name.empty()) continue;
    const auto known = std::find_if(by_reason.begin(), by_reason.end(),
                                    [&](const auto& entry) { return entry.first == each.reason; });
    if (known == by_reason.end())
      by_reason.emplace_back(each.reason, name);
    else
      known->second += ", " + name;
  }
  std::string text;
  for (const auto& [reason, names] : by_reason)
    text.append(text.empty() ? "not defined on this arc: " : "; ")
        .append(names)
        .append(" (")
        .append(reason)
        .append(")");
  return text;
}

/// "driven at 47.0 mm/s, 6.0 % below the programmed 50.0 mm/s"; empty where they agree or one is not known.
std::string feed_text(const CircleTrace& trace) {
  constexpr double kAgree = 0.05;
  if (!trace.calculated_feed || !(trace.feed > 0.0)) return "";
  const double off = *trace.calculated_feed / trace.feed - 1.0;
  if (std::abs(off) <= kAgree) return "";
  const auto tenths = [](double value) {
    const long whole = std::lround(10.0 * value);
    return std::to_string(whole / 10) + "." + std::to_string(whole % 10);
  };
  return "driven at " + tenths(to_mm(*trace.calculated_feed)) + " mm/s, " + tenths(100.0 * std::abs(off)) +
         " % " + (off > 0.0 ? "above" : "below") + " the programmed " + tenths(to_mm(trace.feed)) + " mm/s";
}

std::optional<CircleTest> both_directions(const CircleTrace& one, const CircleTrace& other,
                                          const TestSpec& test) {
  const CircleTrace& ccw = one.direction > 0 ? one : other;
  const CircleTrace& cw = one.direction > 0 ? other : one;
  const std::optional<CirclePair> pair = join(ccw, cw, test.circle, {test.filter_upr});
  if (!pair) return std::nullopt;
  CircleTest found;
  found.figures = *pair;
  found.signatures = fit_signatures({ccw, cw}, test.circle.radius, 0.0);
  if (const std::optional<double> radial = radial_angle(test.circle))
    found.radial_signatures = fit_signatures({ccw, cw}, test.circle.radius, *radial);
  return found;
}

}  // namespace

CircleTrace measured_arc(const std::vector<double>& angle, const std::vector<double>& deviation,
                         std::size_t begin, std::size_t end) {
  std::vector<Eigen::Index> known;
  for (std::size_t i = begin; i < end; ++i)
    if (!std::isnan(angle[i])) known.push_back(static_cast<Eigen::Index>(i));
  const auto all = static_cast<Eigen::Index>(angle.size());
  CircleTrace trace;
  trace.angle = Eigen::Map<const Eigen::VectorXd>(angle.data(), all)(known);
  trace.deviation = Eigen::Map<const Eigen::VectorXd>(deviation.data(), all)(known);
  return trace;
}

void add_circle_figures(const CircleTrace& trace, const TestSpec& test,
                        const std::optional<CircleTrace>& other_way, RunResult& result) {
  CircleSettings settings{test.filter_upr, {}};
  if (result.source == "bar") settings.expansion = test.expansion;  // joints say nothing of what grows
  result.circle_figures = circle_figures(trace, test.circle, settings);
  if (result.status != "ok") return;
  if (!result.circle_figures) {
    if (test.filter_upr)
      result.message = "the samples lie too far apart for filter_upr: no figures by ISO 230-4";
    return;
  }
  std::vector<NotDefined> missing = result.circle_figures->not_defined;
  if (other_way && other_way->direction == -trace.direction)
    result.circle_test = both_directions(trace, *other_way, test);
  if (result.circle_test) {
    const std::vector<NotDefined>& of_pair = result.circle_test->figures.not_defined;
    missing.insert(missing.end(), of_pair.begin(), of_pair.end());
  }
  result.message = not_defined_text(missing);
  if (const std::string feed = feed_text(trace); !feed.empty())
    result.message += (result.message.empty() ? "" : "; ") + feed;
}

}  // namespace ballbar

#include "daemon/simulation.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/service.hpp"
#include "pipeline/catalogue.hpp"
#include "pipeline/circle_test.hpp"
#include "store/trace.hpp"

namespace ballbar {
namespace {

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == ',')
      parts.emplace_back();
    else if (c != ' ')
      parts.back() += c;
  return parts;
}

Run assembled(Assembler& assembler, const SimulatedRun& simulated) {
  std::vector<Run> finished;
  for (const Sample& sample : simulated.samples) assembler.take(sample, sent_us(sample), finished);
  assembler.close_all(RunEnd::kSilence, finished);
  return std::move(finished.at(0));
}

/// What this run gives to the one the other way: of a circle its recording as the store keeps it.
Partners partners_from(const Run& run, const RunResult& result) {
  Partners partners;
  for (const LineResult& line : result.lines) partners.lines.push_back({line.axis, line.points});
  if (result.status != "ok" || result.angle.empty()) return partners;
  const Trace trace = decode(kTraceCoding, encode(make_trace(run, result)));
  partners.circle = measured_arc(trace.angle, trace.bar_deviation, trace.arc_begin, trace.arc_end);
  partners.circle->direction = result.direction;
  partners.circle->feed = run.feed;
  partners.circle->temperature = run.temperature;
  return partners;
}

Json millimetres(const Eigen::Vector3d& v) { return {to_mm(v.x()), to_mm(v.y()), to_mm(v.z())}; }

Json harmonics_json(const HarmonicFit& fit) {
  Json list = Json::array();
  for (int k = 0; k <= fit.order; ++k) {
    const double cos = k == 0 ? fit.mean() : fit.cos(k);
    const double sin = k == 0 ? 0.0 : fit.sin(k);
    list.push_back({{"order", k},
                    {"cos_um", to_um(cos)},
                    {"sin_um", to_um(sin)},
                    {"amplitude_um", to_um(std::hypot(cos, sin))}});
  }
  return list;
}

void put_bar(Json& json, const SimulatedRun& simulated, const CircleSpec& circle) {
  const Eigen::Vector3d programmed(circle.centre[0], circle.centre[1], circle.centre[2]);
  json["ball_mm"] = millimetres(simulated.ball);
  json["centre_shift_mm"] = millimetres(simulated.ball - programmed);
  json["p2p_um"] = to_um(simulated.deviation.maxCoeff() - simulated.deviation.minCoeff());
  json["bar_harmonics"] = harmonics_json(bar_harmonics(simulated));
}

/// A figure that a run may not give.
std::string figure(const Json& value) {
  if (!value.is_number()) return "-";
  char text[40];
  std::snprintf(text, sizeof text, "%.2f", value.get<double>());
  if (std::string(text) == "-0.00") return "0.00";
  return text;
}

std::string harmonic_figure(const Json& run, int order) {
  for (const Json& h : run["harmonics"])
    if (h["order"] == order) return figure(h["amplitude_um"]);
  return "-";
}

}  // namespace

std::optional<double> finite_number(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

EffectSpec parse_effect(const std::string& text) {
  const auto refuse = [&text](const std::string& why) {
    return Error(Cause::kInput, "--effect '" + text + "': " + why +
                                    "; write it as joint_zero_offset,joint=3,offset_deg=0.172");
  };
  const std::vector<std::string> parts = split(text);
  EffectSpec effect;
  effect.effect = parts.front();
  if (effect.effect.empty() || effect.effect.find('=') != std::string::npos)
    throw refuse("begins with the effect's name");
  std::set<std::string> seen;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const std::size_t equals = parts[i].find('=');
    const std::string key = parts[i].substr(0, equals);
    if (equals == std::string::npos || key.empty() || equals + 1 == parts[i].size())
      throw refuse("'" + parts[i] + "' is no NAME=VALUE");
    if (!seen.insert(key).second) throw refuse("'" + key + "' stands there twice");
    const std::string value = parts[i].substr(equals + 1);
    const std::optional<double> number = finite_number(value);
    if (key == "joint") {
      if (!number || *number < 0 || *number > kMaxChainJoints || *number != std::floor(*number))
        throw refuse("'joint' is a whole number from 1, not '" + value + "'");
      effect.joint = static_cast<int>(*number);
    } else if (number) {
      effect.parameters[key] = *number;
    } else {
      effect.words[key] = value;
    }
  }
  return effect;
}

Json effects_json(const std::vector<EffectSpec>& effects) {
  Json list = Json::array();
  for (const EffectSpec& effect : effects) {
    Json& json = list.emplace_back(Json{{"effect", effect.effect}});
    if (effect.joint > 0) json["joint"] = effect.joint;
    for (const auto& [name, word] : effect.words) json[name] = word;
    for (const auto& [name, value] : effect.parameters) json[name] = value;
  }
  return list;
}

Simulation::Simulation(const RobotSpec& robot, const AsBuilt& known)
    : robot_(robot), known_(known), assembler_({robot}) {}

Json Simulation::analyse(const SimulatedRun& simulated) {
  const TestSpec& test = *robot_.find_test(simulated.test);
  const Run run = assembled(assembler_, simulated);
  Partners& other_way = partners_[{run.test, -run.direction}];
  if (repetition_[run.test] != run.repetition) other_way.circle.reset();
  repetition_[run.test] = run.repetition;
  const RunResult result = process(run, test, &known_, other_way);
  partners_[{run.test, run.direction}] = partners_from(run, result);
  Json json = to_json(stored_run(run, result, records(run, result)));
  json.erase("id");
  if (test.kind == TestKind::kCircle) put_bar(json, simulated, test.circle);
  return json;
}

RunResult Simulation::judge(const SimulatedRun& simulated) {
  return process_measured(assembled(assembler_, simulated), *robot_.find_test(simulated.test),
                          &known_.model());
}

void print_simulation(const Json& runs) {
  bool circles = false;
  bool lines = false;
  for (const Json& run : runs) {
    if (run["kind"] != "circle") continue;
    if (!circles)
      std::printf("%-14s %-10s %10s %10s %10s %10s %10s %12s\n", "run", "status", "mean um", "h2 um", "h3 um",
                  "h4 um", "h5 um", "circ. dev um");
    circles = true;
    std::printf("%-14s %-10s %10s %10s %10s %10s %10s %12s\n", run["run"].get<std::string>().c_str(),
                run["status"].get<std::string>().c_str(), figure(run["mean_radius_deviation_um"]).c_str(),
                harmonic_figure(run, 2).c_str(), harmonic_figure(run, 3).c_str(),
                harmonic_figure(run, 4).c_str(), harmonic_figure(run, 5).c_str(),
                figure(run["circular_deviation_um"]).c_str());
  }
  for (const Json& run : runs) {
    if (run["kind"] != "line") continue;
    if (!lines)
      std::printf("%-14s %-10s %-4s %16s %16s %16s %16s\n", "run", "status", "axis", "min. zone um",
                  "least squares um", "end points um", "reversal max um");
    lines = true;
    const Json axes = run.contains("axes") ? run["axes"] : Json::array({run});
    for (const Json& line : axes)
      std::printf("%-14s %-10s %-4s %16s %16s %16s %16s\n", run["run"].get<std::string>().c_str(),
                  run["status"].get<std::string>().c_str(), line["axis"].get<std::string>().c_str(),
                  figure(line["straightness_mz_um"]).c_str(), figure(line["straightness_ls_um"]).c_str(),
                  figure(line["straightness_ep_um"]).c_str(), figure(line["reversal_max_um"]).c_str());
  }
}

}  // namespace ballbar

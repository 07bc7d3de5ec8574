#include "engine.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace blind {
namespace {

constexpr double kStep = 0.5e-3;            // [s]
constexpr double kLead = 2.0, kTail = 0.1;  // [s] driven before and after the recording

struct Row {
  Joints motor;
  std::array<double, 3> tool;
};

/// Value at `time` since the first step, straight between steps.
template <typename Value>
Value at(const std::vector<Row>& rows, double time, Value Row::*which) {
  const double step = time / kStep;
  const auto k = static_cast<std::size_t>(step);
  const double share = step - static_cast<double>(k);
  Value value{};
  for (std::size_t i = 0; i < value.size(); ++i)
    value[i] = (1.0 - share) * (rows.at(k).*which)[i] + share * (rows.at(k + 1).*which)[i];
  return value;
}

}  // namespace

std::vector<Driven> drive_with(const std::string& command_line, const std::filesystem::path& folder,
                               const Physics& p, const Plan& plan) {
  std::filesystem::create_directories(folder);
  nlohmann::json job;
  job["robot"] = {{"step_s", kStep},
                  {"zero_offset", p.zero_offset},
                  {"compliance", p.compliance},
                  {"gap_half", p.gap_half},
                  {"gap_friction", p.gap_friction},
                  {"a", p.geometry.a},
                  {"d", p.geometry.d},
                  {"tool", {p.geometry.tool.x(), p.geometry.tool.y(), p.geometry.tool.z()}},
                  {"masses",
                   {{"upper_arm", p.masses.upper_arm},
                    {"forearm", p.masses.forearm},
                    {"wrist", p.masses.wrist},
                    {"upper_arm_off", p.masses.upper_arm_off},
                    {"forearm_off", p.masses.forearm_off},
                    {"payload_off", p.masses.payload_off}}}};
  std::ofstream commands(folder / "commands.bin", std::ios::binary);
  for (std::size_t i = 0; i < plan.recordings.size(); i += 2) {
    const Test& test = plan.tests[static_cast<std::size_t>(plan.recordings[i].test)];
    const Sampling s = sampling(test);
    const auto count = static_cast<std::size_t>((kLead + s.bar_period * s.bar_count() + kTail) / kStep);
    const std::vector<Joints> way = command(test, plan.recordings[i].direction, -kLead, kStep, count);
    commands.write(reinterpret_cast<const char*>(way.data()),
                   static_cast<std::streamsize>(count * sizeof(Joints)));
    job["ways"].push_back({{"payload_kg", test.payload_kg}, {"count", count}});
  }
  std::ofstream(folder / "job.json") << job;
  if (!commands.flush()) throw std::runtime_error("cannot write " + folder.string());
  commands.close();
  if (std::system((command_line + " '" + folder.string() + "'").c_str()) != 0)
    throw std::runtime_error("failed: " + command_line + " " + folder.string());

  std::ifstream results(folder / "results.bin", std::ios::binary);
  std::vector<Driven> all;
  for (std::size_t i = 0; i < plan.recordings.size(); i += 2) {
    const Sampling s = sampling(plan.tests[static_cast<std::size_t>(plan.recordings[i].test)]);
    std::vector<Row> rows(job["ways"][i / 2]["count"].get<std::size_t>());
    if (!results.read(reinterpret_cast<char*>(rows.data()),
                      static_cast<std::streamsize>(rows.size() * sizeof(Row))))
      throw std::runtime_error("too short: " + (folder / "results.bin").string());
    Driven driven;
    for (int k = 0; k < s.bar_count(); ++k) {
      const double stamp = kLead + s.bar_period * k;
      driven.motor.push_back(at(rows, stamp, &Row::motor));
      const std::array<double, 3> tool = at(rows, stamp + plan.recordings[i].clock_s, &Row::tool);
      driven.tool.emplace_back(tool[0], tool[1], tool[2]);
    }
    all.push_back(std::move(driven));
  }
  std::filesystem::remove_all(folder);
  return all;
}

}  // namespace blind

#pragma once
/// A simulated robot as a diagnosis sees it: driven, assembled, processed, observed.

#include <string>
#include <utility>
#include <vector>

#include "bus/assembler.hpp"
#include "gap/observation.hpp"
#include "gap/simulate.hpp"
#include "pipeline/process.hpp"

namespace ballbar::test {

/// What `ballbar diagnose` makes of the log of `ballbar simulate`.
/// @param known    what the model knows of the robot
/// @param effects  what it has beside that
/// @param change   what is done to a run before it is observed
inline std::vector<Observation> observed(const RobotSpec& known, const RobotModel& model,
                                         const std::vector<EffectSpec>& effects,
                                         const SimulateOptions& options,
                                         const std::function<void(Run&)>& change = {}) {
  RobotSpec truth = known;
  truth.effects.insert(truth.effects.end(), effects.begin(), effects.end());
  const AsBuilt built(model, known), true_robot(model, truth);
  Assembler assembler({known});
  std::vector<MeasuredRun> measured;
  const auto take = [&](std::vector<Run>& runs) {
    for (Run& run : runs) {
      RunResult result = process(run, *known.find_test(run.test), &built);
      if (result.status != "ok")
        throw std::runtime_error(run.test + ": " + result.status + " " + result.message);
      if (change) change(run);
      measured.push_back({std::move(run), std::move(result.angle), result.arc_begin, result.arc_end});
    }
    runs.clear();
  };
  simulate(true_robot, truth, options, [&](const SimulatedRun& run) {
    std::vector<Run> finished;
    for (const Sample& sample : run.samples) assembler.take(sample, sent_us(sample), finished);
    assembler.close_all(RunEnd::kSilence, finished);
    take(finished);
  });
  return observe(std::move(measured), known, model).all;
}

}  // namespace ballbar::test

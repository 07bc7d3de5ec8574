#include "daemon/series_diagnosis.hpp"

#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <iostream>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/config.hpp"
#include "daemon/diagnosis_out.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "gap/diagnose.hpp"
#include "gap/next_test.hpp"

namespace ballbar {
namespace {

using nlohmann::ordered_json;

/// Alone in memory and last in line for the processor: the service comes first.
void step_back() {
  constexpr int kNice = 10;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_NAME, "ballbard-diag");
  if (nice(kNice) < 0) {  // not allowed: slower for all, but no harm
  }
  std::ofstream("/proc/self/oom_score_adj") << "500\n";
}

}  // namespace

bool can_be_diagnosed(const StoredRun& run) {
  if (run.status != "ok") return false;
  if (run.kind == TestKind::kLine) return run.source == "interferometer" && run.predicted_from == "joints";
  return run.source == "bar" && run.angle_source == "joints";
}

MeasuredRun measured_run(const Store& store, const StoredRun& run) {
  Trace trace = store.trace(run.id);
  MeasuredRun one{{}, std::move(trace.angle), trace.arc_begin, trace.arc_end};
  one.run = run_of(run, std::move(trace));
  return one;
}

std::vector<StoredRun> latest_measurement(const Store& store, const std::string& robot,
                                          const std::string& series, std::int64_t apart_us,
                                          std::size_t most) {
  constexpr std::int64_t kPage = 500;  // read at once: a robot may have years of runs
  RunFilter filter;
  filter.robot = robot;
  filter.status = "ok";
  filter.newest_first = filter.labels_only = true;
  filter.limit = kPage;
  std::vector<StoredRun> runs;
  for (bool more = true; more;) {
    std::vector<StoredRun> page = store.runs(filter);
    more = page.size() == kPage;
    for (StoredRun& run : page) {
      filter.until_us = run.started_us;
      // Whatever is that much older: the measurement has begun since.
      const bool another = !runs.empty() && runs.back().started_us - run.ended_us > apart_us;
      const bool of_it =
          (run.series == series || run.series == series + kHeldOutEnding) && can_be_diagnosed(run);
      if (!another && !of_it) continue;
      if (another || runs.size() == most) {
        more = false;
        break;
      }
      runs.push_back(std::move(run));
    }
  }
  std::reverse(runs.begin(), runs.end());
  return runs;
}

DiagnosisInput diagnosis_input(std::vector<MeasuredRun> runs, const RobotSpec& robot, const AsBuilt& built,
                               const std::vector<std::string>& hold_out) {
  DiagnosisInput input;
  Observations observations = observe(std::move(runs), robot, built.model());
  input.left_aside = std::move(observations.left_aside);
  for (Observation& seen : observations.all) {
    const bool held = seen.series.ends_with(kHeldOutEnding) ||
                      std::find(hold_out.begin(), hold_out.end(), seen.test) != hold_out.end();
    (held ? input.held_out : input.fitted).push_back(std::move(seen));
  }
  if (input.fitted.empty())
    throw Error(Cause::kInput,
                "no circle with bar and joints, or line with readings and joints, of robot '" + robot.name +
                    "' is there to be fitted; where all were said to be not used for wrong_path, this is a "
                    "recording of another robot or tool; see which runs there are with ballbar list");
  input.noise = assign_noise(input.fitted);
  assign_noise(input.held_out);
  return input;
}

GapRecord gap_record(const Diagnosis& diagnosis, const std::string& robot, const std::string& series,
                     std::int64_t ended_us) {
  GapRecord record{robot,
                   series,
                   to_string(diagnosis.verdict),
                   ended_us,
                   diagnosis.noise_floor,
                   diagnosis.fit.before,
                   diagnosis.fit.after,
                   {}};
  for (const LeftOut& one : diagnosis.left_out) {
    const auto word = one.spec.words.find("kind");
    record.left_out.push_back({one.spec.effect, word == one.spec.words.end() ? "" : word->second,
                               one.spec.joint, one.level, one.share, one.evidence});
  }
  return record;
}

StoredGap gap_from_text(const std::string& text) {
  try {
    const ordered_json all = ordered_json::parse(text);
    const ordered_json& diagnosis = all.at("diagnosis");
    StoredGap gap;
    gap.started_us = all.at("started_us").get<std::int64_t>();
    gap.json = diagnosis.dump();
    gap.record = {all.at("robot").get<std::string>(),
                  all.at("series").get<std::string>(),
                  diagnosis.at("verdict").get<std::string>(),
                  all.at("ended_us").get<std::int64_t>(),
                  kMetresPerUm * diagnosis.at("noise_floor_um").get<double>(),
                  kMetresPerUm * diagnosis.at("fit").at("rms_before_um").get<double>(),
                  kMetresPerUm * diagnosis.at("fit").at("rms_after_um").get<double>(),
                  {}};
    for (const ordered_json& one : diagnosis.at("left_out"))
      gap.record.left_out.push_back({one.at("effect").get<std::string>(), one.value("kind", ""),
                                     one.at("joint").get<int>(), one.at("level").get<int>(),
                                     one.at("share").get<double>(), one.at("evidence").get<double>()});
    return gap;
  } catch (const nlohmann::json::exception& error) {
    throw Error(Cause::kWorld, std::string("the diagnosis is not whole: ") + error.what());
  }
}

std::string says_of(const StoredGap& gap) {
  const nlohmann::json diagnosis = nlohmann::json::parse(gap.json, nullptr, false);
  return diagnosis.is_object() ? diagnosis.value("says", "") : "";
}

int run_series_diagnosis(const std::vector<std::string>& words) {
  step_back();
  try {
    const std::string &robot_name = words.at(2), &series = words.at(3);
    const Config config = config_of_robot(words.at(0), robot_name);
    const RobotSpec& robot = config.robots.front();
    const Models models = load_models(config);
    const Store store = Store::open_read_only(words.at(1));
    const std::vector<StoredRun> runs = latest_measurement(store, robot_name, series);
    std::vector<MeasuredRun> measured;
    std::int64_t ended_us = 0;
    for (const StoredRun& run : runs) {
      if (!robot.find_test(run.test)) continue;
      measured.push_back(measured_run(store, run));
      ended_us = std::max(ended_us, run.ended_us);
    }
    const AsBuilt& built = models.at(robot_name);
    const DiagnosisInput input = diagnosis_input(std::move(measured), robot, built, {});
    const GapModel model(built, robot);
    Diagnosis diagnosis = diagnose(model, input.fitted, input.held_out, input.noise);
    if (has_twins(diagnosis))
      suggest(plan_for(model, input.fitted, diagnosis, proposed_tests(model, scope_of(input.fitted))),
              diagnosis);
    const ordered_json all{{"robot", robot_name},
                           {"series", series},
                           {"started_us", runs.front().started_us},
                           {"ended_us", ended_us},
                           {"diagnosis", to_json(diagnosis)}};
    std::cout << all.dump() << "\n" << std::flush;
    return std::cout ? 0 : 3;
  } catch (const Error& error) {
    std::cerr << error.what() << "\n";
    return error.cause() == Cause::kInput ? 2 : 3;
  } catch (const std::exception& error) {
    std::cerr << "not foreseen: " << error.what() << "\n";
    return 3;
  }
}

}  // namespace ballbar

#include "gap/observation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <tuple>

#include "core/units.hpp"
#include "gap/line_observation.hpp"
#include "gap/observation_parts.hpp"
#include "gap/predict.hpp"
#include "numerics/vector3.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::int64_t kLongestPause = 600'000'000;  // [us] between laps of one observation
constexpr double kLikeDensity = 1.3;                 // ratio of readings per turn within which noise is alike

Lap lap_of(const MeasuredRun& measured, const CircleSpec& circle) {
  const Run& run = measured.run;
  const double from = run.direction > 0 ? circle.arc_start : circle.arc_start + circle.arc_sweep;
  std::vector<double> x, time, deviation;
  std::optional<double> turns;
  for (std::size_t i = measured.arc_begin; i < measured.arc_end; ++i) {
    if (!std::isfinite(measured.angle[i])) continue;
    double way = run.direction * (measured.angle[i] - from);
    if (!turns) turns = std::round(way / kTurn);
    way = (way - *turns * kTurn) / circle.arc_sweep;
    if (way < 0.0 || way > 1.0 || (!x.empty() && way <= x.back())) continue;
    x.push_back(way);
    time.push_back(run.bar_time[i]);
    deviation.push_back(run.bar_deviation[i]);
  }
  const auto n = static_cast<Index>(x.size());
  return {Eigen::Map<VectorXd>(x.data(), n), Eigen::Map<VectorXd>(time.data(), n),
          Eigen::Map<VectorXd>(deviation.data(), n)};
}

/// A series that is held out belongs to the one that it is named after: the robot has warmed up since that
/// one began.
std::string warm_since(const std::string& series) {
  const bool held_out = series.ends_with(kHeldOutEnding);
  return held_out ? series.substr(0, series.size() - std::string_view(kHeldOutEnding).size()) : series;
}

using Key = std::tuple<std::string, std::string, int, double, double, char>;

/// Laps that belong together; of a line, as read along one axis.
struct Laps {
  std::vector<const MeasuredRun*> runs;
  char axis = ' ';
};

Key key_of(const Run& run, char axis) {
  return {run.series, run.test, run.direction, run.payload, run.feed, axis};
}

/// One observation of laps of a circle; nothing, and a sentence, where they cannot be used.
std::optional<Observation> observe_circle(const std::vector<const MeasuredRun*>& laps, const TestSpec& test,
                                          const RobotModel& model, std::vector<std::string>& left_aside) {
  const CircleSpec& circle = test.circle;
  const double turns = circle.arc_sweep / kTurn;
  std::vector<Lap> usable;
  std::vector<const Run*> used;
  for (const MeasuredRun* measured : laps) {
    Lap lap = lap_of(*measured, circle);
    const Run& run = measured->run;
    if (static_cast<double>(lap.x.size()) < 40.0 * turns || lap.x.size() < 20 ||
        run.joints != model.joints()) {
      left_aside.push_back(run_name(run) + ": too few readings on the arc, or no joints");
      continue;
    }
    usable.push_back(std::move(lap));
    used.push_back(&run);
  }
  if (usable.empty()) return std::nullopt;
  const Run& first = *used.front();
  Observation seen;
  describe(used, seen);
  double density = std::numeric_limits<double>::infinity();
  for (const Lap& lap : usable) density = std::min(density, static_cast<double>(lap.x.size()) / turns);
  const Index places = smooth_number(kPlacesPerTurn * turns);
  seen.transform = CosineTransform(
      places, turns, std::min(kHighestFrequency, density / (2.0 * kValuesPerCoefficient) - 1.0));
  seen.place.resize(places);
  for (Index k = 0; k < places; ++k) {
    const double way = (static_cast<double>(k) + 0.5) / static_cast<double>(places);
    seen.place[k] = circle.arc_start + circle.arc_sweep * (first.direction > 0 ? way : 1.0 - way);
  }
  seen.said = motion_of(first, model);
  if (!set_times(usable.front(), seen)) {
    left_aside.push_back(run_name(first) + ": its joints do not cover the arc");
    return std::nullopt;
  }
  seen.instrument = {TestKind::kCircle, vector_of(circle.centre), circle.radius};
  seen.conditions.ball = seen.instrument.origin;
  seen.readings_per_turn = density;
  seen.laps.resize(seen.transform.frequency().size(), static_cast<Index>(usable.size()));
  for (std::size_t i = 0; i < usable.size(); ++i)
    seen.laps.col(static_cast<Index>(i)) = seen.transform.fit(usable[i].x, usable[i].deviation);
  seen.measured = seen.laps.rowwise().mean();
  return seen;
}

std::optional<Observation> observation_of(const Laps& laps, const RobotSpec& robot, const RobotModel& model,
                                          std::vector<std::string>& left_aside) {
  const TestSpec& test = *robot.find_test(laps.runs.front()->run.test);
  return test.kind == TestKind::kCircle ? observe_circle(laps.runs, test, model, left_aside)
                                        : observe_line(laps.runs, laps.axis, test, model, left_aside);
}

/// Level of the upper half of a single lap's coefficients: what a lap knows of its own noise.
double white_of(const Observation& seen) {
  const Index from = seen.measured.size() * 2 / 3;
  std::vector<double> energy;
  for (Index k = from; k < seen.measured.size(); ++k) energy.push_back(seen.measured[k] * seen.measured[k]);
  const auto middle = energy.begin() + static_cast<std::ptrdiff_t>(energy.size() / 2);
  std::nth_element(energy.begin(), middle, energy.end());
  return *middle / 0.4549 * static_cast<double>(seen.laps.cols());  // median of chi2 with one degree
}

/// Which of some recordings have laps that differ far more slowly than those of the others: something has
/// moved between them, a quarter of them at most.
std::vector<bool> moved_between_laps(const std::vector<RepeatScatter>& scatter) {
  constexpr double kStandsOut = 6.0;  // times the median: by chance one in a million with eight coefficients
  constexpr std::size_t kLeast = 8;   // fewer do not say what is usual
  std::vector<bool> moved(scatter.size(), false);
  if (scatter.size() < kLeast) return moved;
  std::vector<double> slow;
  for (const RepeatScatter& each : scatter) {
    double energy = 0.0, count = 0.0;
    for (Index k = 0; k < each.frequency.size() && each.frequency[k] < kNoiseBandBegin[1]; ++k) {
      energy += each.energy[k];
      count += each.dof;
    }
    slow.push_back(count > 0.0 ? energy / count : 0.0);
  }
  std::vector<double> sorted = slow;
  std::sort(sorted.begin(), sorted.end());
  const double limit = kStandsOut * sorted[sorted.size() / 2];
  if (sorted[sorted.size() - 1 - sorted.size() / 4] > limit) return moved;
  for (std::size_t i = 0; i < slow.size(); ++i) moved[i] = slow[i] > limit;
  return moved;
}

/// That is no noise.
std::vector<RepeatScatter> without_jumps(std::vector<RepeatScatter> scatter) {
  const std::vector<bool> moved = moved_between_laps(scatter);
  std::vector<RepeatScatter> kept;
  for (std::size_t i = 0; i < scatter.size(); ++i)
    if (!moved[i]) kept.push_back(std::move(scatter[i]));
  return kept;
}

/// Laps between which something has moved are observations of their own, so that it has a moment. Bars and
/// optics are held against their like.
std::vector<Laps> parted_where_moved(const std::vector<Laps>& groups, const RobotSpec& robot,
                                     const RobotModel& model) {
  std::vector<bool> part(groups.size(), false);
  for (const bool line : {false, true}) {
    std::vector<RepeatScatter> scatter;
    std::vector<std::size_t> of;
    for (std::size_t i = 0; i < groups.size(); ++i) {
      if ((groups[i].axis != ' ') != line) continue;
      std::vector<std::string> said;  // the second time they are observed it is told
      const std::optional<Observation> seen = observation_of(groups[i], robot, model, said);
      if (!seen || seen->laps.cols() < 2) continue;
      scatter.push_back(repeat_scatter(seen->transform.frequency(), seen->laps));
      of.push_back(i);
    }
    const std::vector<bool> moved = moved_between_laps(scatter);
    for (std::size_t k = 0; k < of.size(); ++k) part[of[k]] = moved[k];
  }
  std::vector<Laps> parted;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (!part[i]) {
      parted.push_back(groups[i]);
      continue;
    }
    for (const MeasuredRun* lap : groups[i].runs) parted.push_back({{lap}, groups[i].axis});
  }
  std::stable_sort(parted.begin(), parted.end(), [](const Laps& a, const Laps& b) {
    return a.runs.front()->run.started_us < b.runs.front()->run.started_us;
  });
  return parted;
}

/// Axes that a run was read along; of a circle none, which is one.
std::string axes_to_observe(const Run& run, const TestSpec& test) {
  return test.kind == TestKind::kCircle ? " " : axes_of(run);
}

/// Where the ball stands, or by what the optics are aligned.
using SetUp = std::tuple<std::string, std::string, char, Vec3>;

SetUp set_up_of(const Observation& seen, const TestSpec& test) {
  if (seen.instrument.is_bar()) return {seen.series, "", ' ', test.circle.centre};
  return {seen.series, seen.test, seen.instrument.axis, {}};
}

}  // namespace

Observations observe(std::vector<MeasuredRun> runs, const RobotSpec& robot, const RobotModel& model) {
  std::stable_sort(runs.begin(), runs.end(), [](const MeasuredRun& a, const MeasuredRun& b) {
    return a.run.started_us < b.run.started_us;
  });
  Observations found;
  std::vector<Laps> groups;
  std::map<Key, std::size_t> open;
  std::string last_test;
  for (const MeasuredRun& measured : runs) {
    const Run& run = measured.run;
    const TestSpec* test = robot.find_test(run.test);
    if (!test || run.direction == 0) {
      found.left_aside.push_back(run_name(run) + ": no circle or line of a configured test with a direction");
      continue;
    }
    const std::string label = run.series + "\n" + run.test;
    if (label != last_test) open.clear();
    last_test = label;
    for (const char axis : axes_to_observe(run, *test)) {
      const auto earlier = open.find(key_of(run, axis));
      if (earlier != open.end() &&
          run.started_us - groups[earlier->second].runs.back()->run.ended_us < kLongestPause) {
        groups[earlier->second].runs.push_back(&measured);
        continue;
      }
      open[key_of(run, axis)] = groups.size();
      groups.push_back({{&measured}, axis});
    }
  }
  std::map<std::string, std::int64_t> series_begin;
  std::map<SetUp, int> set_ups;
  for (const Laps& laps : parted_where_moved(groups, robot, model)) {
    std::optional<Observation> seen = observation_of(laps, robot, model, found.left_aside);
    if (!seen) continue;
    const auto begin = series_begin.try_emplace(warm_since(seen->series), seen->begin_us);
    seen->conditions.series_time += static_cast<double>(seen->begin_us - begin.first->second) * 1e-6;
    seen->set_up =
        set_ups.try_emplace(set_up_of(*seen, *robot.find_test(seen->test)), static_cast<int>(set_ups.size()))
            .first->second;
    found.all.push_back(std::move(*seen));
  }
  return found;
}

double even_out(Observation& seen) {
  const auto places = static_cast<double>(seen.places());
  const double count = seen.instrument.is_bar() ? places : kPlacesPerTurn;
  seen.variance.setConstant(1e-12 * places / count);
  return count;
}

NoiseLevel assign_noise(std::vector<Observation>& observations) {
  NoiseLevel level;
  std::vector<std::size_t> order(observations.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto key = [](const Observation& seen) {
    return std::pair(!seen.instrument.is_bar(), seen.readings_per_turn);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return key(observations[a]) < key(observations[b]); });
  double mean_energy = 0.0, lap_energy = 0.0;
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    const auto [optics, least] = key(observations[order[begin]]);
    std::vector<RepeatScatter> scatter;
    double white = 0.0;
    for (end = begin; end < order.size(); ++end) {
      const Observation& seen = observations[order[end]];
      if (key(seen).first != optics || seen.readings_per_turn > kLikeDensity * least) break;
      white += white_of(seen);
      if (seen.laps.cols() > 1) scatter.push_back(repeat_scatter(seen.transform.frequency(), seen.laps));
    }
    const NoiseSpectrumFit fit = fit_noise_spectrum(without_jumps(std::move(scatter)));
    NoiseSpectrum spectrum = fit.spectrum;
    if (fit.status == FitStatus::kOk) {
      level.from_repeats = true;
    } else {
      white /= static_cast<double>(end - begin);
      spectrum = {white, 10.0 * white, 5.0};
    }
    for (std::size_t i = begin; i < end; ++i) {
      Observation& seen = observations[order[i]];
      const VectorXd lap = spectrum.variance(seen.transform.frequency());
      seen.variance = lap / static_cast<double>(seen.laps.cols());
      mean_energy += seen.variance.sum() / static_cast<double>(seen.places());
      lap_energy += lap.sum() / static_cast<double>(seen.places());
    }
  }
  if (!observations.empty()) {
    level.floor = std::sqrt(mean_energy / static_cast<double>(observations.size()));
    level.lap = std::sqrt(lap_energy / static_cast<double>(observations.size()));
  }
  return level;
}

}  // namespace ballbar

/// Recordings with concealed effects, and the answers. Shares no code with lib/: own kinematics, own physics.
///   blind_generator --seed 7 --kind main --urdf lrmate200ic.urdf -o CASE --answer ANSWER.json

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <iostream>
#include <map>
#include <stdexcept>

#include "baseline.hpp"
#include "draw.hpp"
#include "engine.hpp"
#include "log.hpp"

namespace blind {
namespace {

namespace fs = std::filesystem;

constexpr double kEpochUs = 1.77e15, kApartUs = 1000e6;
constexpr double kWhiteUm = 0.7, kSlowUm = 0.7, kSlowness = 0.97;  // the last per sample of a lap of 400
constexpr double kEngineFeed =
    110;  // [mm/s] at most; beyond, links coast through gaps in ways of the engine's own
constexpr double kClock = 0.010, kScale = 1e-3, kZeroUm = 2.0, kBall = 20e-6;

/// All that a case has beside its physics.
struct Setting {
  Plan plan;
  std::map<std::string, Vector3d> ball;  ///< place of the ball by the first test of its set-up
  std::vector<std::string> setup;        ///< that test's name, of every test
  std::vector<double> vibration_phase;   ///< of every recording
};

struct Run {
  std::vector<std::vector<Joints>> asked;  ///< two recordings share one
  std::vector<std::vector<Joints>> torque;
  std::vector<std::vector<double>> length;  ///< one per recording [m]
  std::vector<std::vector<double>>
      gap;  ///< the same, less what the joints on the wire say, where they are feedback
};

Run drive(const Physics& physics, const Setting& s) {
  Run run;
  Way now;
  for (std::size_t i = 0; i < s.plan.recordings.size(); ++i) {
    const Recording& r = s.plan.recordings[i];
    const auto which = static_cast<std::size_t>(r.test);
    if (i % 2 == 0) {
      now = way(physics, s.plan.tests[which], r.direction, r.clock_s);
      run.asked.push_back(now.asked);
      run.torque.push_back(now.torque);
    }
    run.length.push_back(bar(physics, now, s.plan, r, s.ball.at(s.setup[which]), s.vibration_phase[i]));
  }
  run.gap = run.length;
  return run;
}

/// The bar of an arm that another program has driven; its motors' feedback is on the wire.
Run measured(const std::vector<Driven>& driven, const Setting& s) {
  Run run;
  const Deviations none;
  for (std::size_t i = 0; i < s.plan.recordings.size(); ++i) {
    const auto which = static_cast<std::size_t>(s.plan.recordings[i].test);
    const Driven& way = driven[i / 2];
    if (i % 2 == 0) run.asked.push_back(way.motor);
    const Vector3d ball = s.ball.at(s.setup[which]), centre = 1e-3 * s.plan.tests[which].centre_mm;
    std::vector<double> length, gap;
    for (std::size_t k = 0; k < way.tool.size(); ++k) {
      length.push_back((way.tool[k] - ball).norm() - 1e-3 * s.plan.tests[which].radius_mm);
      gap.push_back((way.tool[k] - ball).norm() - (tool_point(way.motor[k], none) - centre).norm());
    }
    run.length.push_back(std::move(length));
    run.gap.push_back(std::move(gap));
  }
  return run;
}

/// Each ball amid the tool points of the first circle about it.
void set_balls(Setting& s, const std::vector<Driven>& driven, Random random) {
  for (std::size_t i = 0; i < driven.size(); ++i) {
    const auto which = static_cast<std::size_t>(s.plan.recordings[2 * i].test);
    if (s.ball.contains(s.setup[which])) continue;
    Vector3d mean = Vector3d::Zero();
    const std::vector<std::size_t> at = kept(s.plan.tests[which]);
    for (const std::size_t k : at) mean += driven[i].tool[k] / static_cast<double>(at.size());
    s.ball[s.setup[which]] = mean + random.normal3(kBall);
  }
}

std::vector<const std::vector<Joints>*> per_recording(const Run& run) {
  std::vector<const std::vector<Joints>*> all;
  for (std::size_t i = 0; i < run.length.size(); ++i) all.push_back(&run.asked[i / 2]);
  return all;
}

Setting setting(const Kind& kind, Random& random) {
  Setting s;
  s.plan = plan(kind.plan);
  for (std::size_t i = 0; i < s.plan.recordings.size(); ++i) {
    Recording& r = s.plan.recordings[i];
    r.clock_s = i % 2 == 0 ? std::clamp(random.normal(kClock), -3 * kClock, 3 * kClock)
                           : s.plan.recordings[i - 1].clock_s;
    s.vibration_phase.push_back(random.uniform(0, 2 * std::numbers::pi));
  }
  for (const Test& test : s.plan.tests) {
    const auto first = std::find_if(s.plan.tests.begin(), s.plan.tests.end(),
                                    [&](const Test& t) { return t.centre_mm == test.centre_mm; });
    s.setup.push_back(first->name);
  }
  return s;
}

void set_balls(Setting& s, const Physics& physics, Random random) {
  for (std::size_t i = 0; i < s.plan.tests.size(); ++i)
    if (s.setup[i] == s.plan.tests[i].name)
      s.ball[s.setup[i]] = ball_place(physics, s.plan.tests[i], random.normal3(kBall));
}

std::vector<double> noise_um(std::size_t count, double per_sample, double factor, Random& random) {
  std::vector<double> noise(count);
  const double keep = std::pow(kSlowness, per_sample);
  double slow = random.normal(kSlowUm);
  for (double& n : noise) {
    n = factor * (slow + random.normal(kWhiteUm));
    slow = keep * slow + random.normal(kSlowUm * std::sqrt(1.0 - keep * keep));
  }
  return noise;
}

double rms(const std::vector<double>& of) {
  double sum = 0.0;
  for (const double v : of) sum += v * v;
  return std::sqrt(sum / static_cast<double>(of.size()));
}

/// Noise of the measured arc, averaged to 400 samples a turn.
std::vector<double> averaged(const std::vector<double>& noise, const Test& test) {
  const std::vector<std::size_t> at = kept(test);
  const std::size_t width = at[1] - at[0];
  std::vector<double> mean;
  for (const std::size_t k : at) {
    double sum = 0.0;
    for (std::size_t i = 0; i < width; ++i) sum += noise[k + i];
    mean.push_back(sum / static_cast<double>(width));
  }
  return mean;
}

/// Slope of the straight line through the deflections of the fitted recordings, per slope drawn.
double straightened(const Run& run, const Plan& plan, int joint) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < plan.recordings.size(); i += 2)
    if (!plan.recordings[i].held_out)
      for (const std::size_t k : kept(plan.tests[static_cast<std::size_t>(plan.recordings[i].test)])) {
        const double load = run.torque[i / 2][k][static_cast<std::size_t>(joint)];
        const double bent = deflection(1.0, load, joint);
        n += 1, x += load, y += bent, xx += load * load, xy += load * bent;
      }
  return (xy - x * y / n) / (xx - x * x / n);
}

std::vector<std::pair<double, double>> visited(const Run& run, const Plan& plan) {
  std::vector<std::pair<double, double>> range(6, {1e9, -1e9});
  for (std::size_t i = 0; i < plan.recordings.size(); i += 2)
    if (!plan.recordings[i].held_out)
      for (const Joints& q : run.asked[i / 2])
        for (std::size_t j = 0; j < 6; ++j)
          range[j] = {std::min(range[j].first, q[j]), std::max(range[j].second, q[j])};
  return range;
}

struct Options {
  int seed = -1;
  std::string kind = "main", plan, engine;
  fs::path urdf, out, answer;
};

class Case {
 public:
  explicit Case(const Options& o)
      : options_(o), kind_(kind_named(o.kind)), begin_us_(kEpochUs + kApartUs * o.seed) {
    if (!o.plan.empty()) kind_.plan = o.plan;
    Random setting_random(seed(), "setting"), always_random(seed(), "always");
    setting_ = setting(kind_, setting_random);
    bare_ = always_present(always_random);
    Random effects_random(seed(), "effects of " + o.kind);
    if (kind_.engine)
      drive_by_engine(effects_random);
    else
      drive_by_own(effects_random);
    std::stable_sort(planted_.begin(), planted_.end(), [](const Planted& a, const Planted& b) {
      return a.answer["signal_um"].get<double>() > b.answer["signal_um"].get<double>();
    });
    measure();
  }

  void write() const {
    fs::create_directories(options_.out);
    const auto text = [](const fs::path& file, const std::string& content) {
      std::ofstream out(file);
      out << content;
      if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
    };
    const bool fanuc = options_.seed % 2 == 0;
    write_log(options_.out / "recording.lcm", setting_.plan, recorded_, series(), begin_us_, fanuc,
              100 + options_.seed % 1000);
    text(options_.out / "ballbard.toml", configuration(setting_.plan, fanuc, wire()));
    fs::copy_file(options_.urdf, options_.out / "lrmate200ic.urdf", fs::copy_options::overwrite_existing);
    if (options_.answer.has_parent_path()) fs::create_directories(options_.answer.parent_path());
    text(options_.answer, answer().dump(1) + "\n");
  }

 private:
  std::uint64_t seed() const { return static_cast<std::uint64_t>(options_.seed); }
  std::string wire() const { return kind_.engine ? "motor feedback" : "commanded"; }
  std::string series() const { return "case-" + std::to_string(options_.seed); }

  /// Physics of the case without the effect of that number; with all where there is none such.
  Physics without(std::size_t number) const {
    Physics p = bare_;
    for (std::size_t i = 0; i < planted_.size(); ++i)
      if (i != number) planted_[i].apply(p);
    return p;
  }

  void drive_by_own(Random& random) {
    planted_ = draw_effects(kind_, setting_.plan, begin_us_, random);
    set_balls(setting_, bare_, Random(seed(), "balls"));
    const Run nominal = drive(bare_, setting_);
    const Baseline baseline(setting_.plan, per_recording(nominal));
    if (kind_.outside) add_outsider(nominal, baseline);
    if (kind_.background_most_um > 0.0) add_background(nominal, baseline);
    set_balls(setting_, without(planted_.size()), Random(seed(), "balls"));
    run_ = drive(without(planted_.size()), setting_);
    for (std::size_t i = 0; i < planted_.size(); ++i) {
      ordered_json& answer = planted_[i].answer;
      if (answer["effect"] == "joint_compliance") {
        const double drawn = answer["parameters"][0]["value"];
        answer["drawn"] = drawn;
        answer["parameters"][0]["value"] =
            drawn * straightened(run_, setting_.plan, answer["joint"].get<int>() - 1);
      }
      answer["signal_um"] = baseline.left_um(run_.gap, drive(without(i), setting_).gap);
    }
  }

  void drive_by_engine(Random& random) {
    if (options_.engine.empty())
      throw std::invalid_argument("kind '" + options_.kind + "' needs --engine COMMAND");
    planted_ = draw_for_engine(random);
    for (Test& test : setting_.plan.tests) test.feed_mm_s = std::min(test.feed_mm_s, kEngineFeed);
    const auto engine = [&](const Physics& physics) {
      return drive_with(options_.engine, options_.out / "job", physics, setting_.plan);
    };
    const std::vector<Driven> driven = engine(without(planted_.size()));
    set_balls(setting_, driven, Random(seed(), "balls"));
    run_ = measured(driven, setting_);
    const Baseline baseline(setting_.plan, per_recording(run_));
    for (std::size_t i = 0; i < planted_.size(); ++i)
      planted_[i].answer["signal_um"] =
          baseline.left_um(run_.gap, measured(engine(without(i)), setting_).gap);
  }

  void add_outsider(const Run& nominal, const Baseline& baseline) {
    Random random(seed(), "outsider");
    const auto range = visited(nominal, setting_.plan);
    for (;;) {
      Outsider o = draw_outsider(range, random);
      const double unit = 1e-5, wanted = random.log_uniform(2.0, 20.0);
      Physics with = bare_;
      Strange trial = o.strange;
      trial.amplitude *= unit;
      with.strange.push_back(trial);
      const double size = wanted / baseline.left_um(drive(with, setting_).length, nominal.length);
      o.strange.amplitude *= unit * size;
      // The largest angle that a unit of the driver makes here; more than 2 mrad is no small error any more.
      const double driver = o.strange.shape == Strange::Shape::kSpeed ? 0.5
                            : o.strange.shape == Strange::Shape::kTorqueSquared
                                ? (o.strange.joint == 4 ? 16 : 1600)
                                : 1.0;
      if (!(std::abs(o.strange.amplitude) * driver < 2e-3)) continue;
      o.answer["parameters"] = ordered_json::array({{{"name", "amplitude"}, {"value", o.strange.amplitude}}});
      const Strange strange = o.strange;
      planted_.push_back({[strange](Physics& p) { p.strange.push_back(strange); }, o.answer});
      return;
    }
  }

  void add_background(const Run& nominal, const Baseline& baseline) {
    Random random(seed(), "background");
    const Physics background = draw_background(random);
    const double wanted = random.uniform(kind_.background_least_um, kind_.background_most_um);
    const double whole =
        baseline.left_um(drive(with_background(bare_, background, 1.0), setting_).length, nominal.length);
    bare_ = with_background(bare_, background, wanted / whole);
    background_um_ = baseline.left_um(drive(bare_, setting_).length, nominal.length);
  }

  void measure() {
    Random random(seed(), "bar"), noise_random(seed(), "noise of " + options_.kind);
    scale_ = random.normal(kScale);
    zero_um_ = random.normal(kZeroUm);
    std::vector<double> lap, lap_mean, mean_of_two, before;
    for (std::size_t i = 0; i < setting_.plan.recordings.size(); ++i) {
      const Recording& r = setting_.plan.recordings[i];
      const Test& test = setting_.plan.tests[static_cast<std::size_t>(r.test)];
      const std::vector<double>& length = run_.length[i];
      const std::vector<double> noise =
          noise_um(length.size(), static_cast<double>(kPerTurn) / (4.0 * sampling(test).joints_per_turn),
                   kind_.noise, noise_random);
      Recorded recorded{.of = r, .joints = kind_.engine ? run_.asked[i / 2] : sent(r), .deviation_um = {}};
      for (std::size_t k = 0; k < length.size(); ++k)
        recorded.deviation_um.push_back(1e6 * length[k] * (1.0 + scale_) + zero_um_ + noise[k]);
      recorded_.push_back(std::move(recorded));
      lap.push_back(rms(noise));
      const std::vector<double> mean = averaged(noise, test);
      lap_mean.push_back(rms(mean));
      if (i % 2 == 1) {
        std::vector<double> two = mean;
        for (std::size_t k = 0; k < two.size(); ++k) two[k] = 0.5 * (two[k] + before[k]);
        mean_of_two.push_back(rms(two));
      }
      before = mean;
    }
    noise_ = {{"one_lap_at_recorded_rate", rms(lap)},
              {"one_lap_averaged_to_400_samples", rms(lap_mean)},
              {"mean_of_two_laps_averaged_to_400_samples", rms(mean_of_two)}};
  }

  /// What the controller sends: its command, at the robot's own clock.
  std::vector<Joints> sent(const Recording& r) const {
    const Test& test = setting_.plan.tests[static_cast<std::size_t>(r.test)];
    const Sampling s = sampling(test);
    return command(test, r.direction, 0.0, s.bar_period, static_cast<std::size_t>(s.bar_count()));
  }

  std::vector<std::string> verdicts() const {
    if (kind_.outside) {
      std::vector<std::string> all = {"unknown_effect", "partly_explained"};
      if (planted_.front().answer.contains("accept_effect")) all.emplace_back("explained");
      return all;
    }
    const double most = planted_.empty() ? 0.0 : planted_.front().answer["signal_um"].get<double>();
    std::vector<std::string> all;
    if (most > 0.0) all.emplace_back("explained");
    if (kind_.background_most_um > 0.0 || (kind_.engine && most > 0.0)) all.emplace_back("partly_explained");
    if (most < 1.0 && kind_.background_most_um == 0.0) all.emplace_back("nothing_missing");
    return all;
  }

  ordered_json answer() const {
    const Plan& plan = setting_.plan;
    ordered_json a = {{"kind", options_.kind},
                      {"plan", kind_.plan},
                      {"seed", options_.seed},
                      {"generator", kind_.engine ? "MuJoCo" : "blind_generator"},
                      {"joint_convention", options_.seed % 2 == 0 ? "fanuc" : "serial"},
                      {"joints_on_the_wire", wire()},
                      {"verdict", verdicts().front()},
                      {"accept_verdict", verdicts()},
                      {"planted", ordered_json::array()}};
    for (const Planted& p : planted_) a["planted"].push_back(p.answer);
    a["signal_um_means"] =
        "RMS over the fit runs of (recording with the effect - without it) after projecting off zero offsets "
        "J2..J5, ball "
        "centres, bar length; 400 samples a lap";
    if (kind_.background_most_um > 0.0) a["background_um"] = background_um_;
    a["noise_floor_um"] = noise_;
    a["held_out_tests"] = {"H", "H2"};
    a["fit_tests"] = ordered_json::array();
    for (const Test& test : plan.tests)
      if (test.name[0] != 'H') a["fit_tests"].push_back(test.name);
    a["series"] = {{"fit", series()}, {"held_out", series() + "-held-out"}};
    for (const Recording& r : plan.recordings) {
      const std::string way = plan.tests[static_cast<std::size_t>(r.test)].name +
                              (r.direction > 0 ? "+1#" : "-1#") + std::to_string(r.repetition);
      a["runs"].push_back(way);
      a["always_present"]["time_shift_ms"][way] = 1e3 * r.clock_s;
    }
    for (const double offset : bare_.zero_offset)
      a["always_present"]["joint_zero_offset_deg"].push_back(offset / kRad);
    a["always_present"]["bar_scale"] = scale_;
    a["always_present"]["bar_zero_um"] = zero_um_;
    const Masses& m = bare_.masses;
    a["always_present"]["masses"] = {{"upper_arm", m.upper_arm},
                                     {"forearm", m.forearm},
                                     {"wrist", m.wrist},
                                     {"upper_arm_off_mm", 1e3 * m.upper_arm_off},
                                     {"forearm_off_mm", 1e3 * m.forearm_off},
                                     {"payload_off_mm", 1e3 * m.payload_off}};
    return a;
  }

  Options options_;
  Kind kind_;
  double begin_us_;
  Setting setting_;
  Physics bare_;  ///< without the concealed effects
  std::vector<Planted> planted_;
  Run run_;
  std::vector<Recorded> recorded_;
  double background_um_ = 0.0, scale_ = 0.0, zero_um_ = 0.0;
  ordered_json noise_;
};

Options parse(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    if (i + 1 == argc) throw std::invalid_argument("no value for '" + name + "'");
    const std::string value = argv[i + 1];
    if (name == "--seed")
      o.seed = std::stoi(value);
    else if (name == "--kind")
      o.kind = value;
    else if (name == "--plan")
      o.plan = value;
    else if (name == "--engine")
      o.engine = value;
    else if (name == "--urdf")
      o.urdf = value;
    else if (name == "-o")
      o.out = value;
    else if (name == "--answer")
      o.answer = value;
    else
      throw std::invalid_argument("unknown option '" + name + "'");
  }
  if (o.seed < 0 || o.urdf.empty() || o.out.empty() || o.answer.empty())
    throw std::invalid_argument(
        "usage: blind_generator --seed N --kind "
        "main|null|weak|noisy|clutter|heavy-clutter|outside|slip|p0|p3|mujoco [--engine COMMAND] [--plan "
        "PM|P0|P3] "
        "--urdf FILE -o DIRECTORY --answer FILE");
  return o;
}

}  // namespace
}  // namespace blind

int main(int argc, char** argv) try {
  blind::Case(blind::parse(argc, argv)).write();
} catch (const std::invalid_argument& e) {
  std::cerr << "blind_generator: " << e.what() << "\n";
  return 2;
} catch (const std::exception& e) {
  std::cerr << "blind_generator: " << e.what() << "\n";
  return 3;
}

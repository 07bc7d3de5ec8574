// A run in, a result out: recordings of a planar arm with a known answer.

#include "pipeline/process.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "core/units.hpp"
#include "metrology/circle.hpp"
#include "pipeline/catalogue.hpp"
#include "pipeline/circle_test.hpp"
#include "support/planar_cell.hpp"

namespace ballbar {
namespace {

using test::PlanarCircle;

const AsBuilt& planar() {
  static const AsBuilt robot(RobotModel(test::kPlanarUrdf, "base", "tcp", JointConvention::kSerial), {});
  return robot;
}

RunResult result_of(const PlanarCircle& circle) {
  return process(test::planar_run(circle), test::planar_test(circle), &planar());
}

double value(const ballbar::Run& run, const RunResult& result, const std::string& name) {
  return records(run, result).front().values.at(name).value;
}

TEST(Process, FindsTheOvalThatWasDriven) {
  PlanarCircle circle;
  circle.shape = [](double a) { return 50e-6 * std::cos(2 * (a - 0.3)) + 10e-6; };
  for (const int direction : {1, -1}) {
    circle.direction = direction;
    const ballbar::Run run = test::planar_run(circle);
    const RunResult result = result_of(circle);
    EXPECT_EQ(result.status, "ok") << result.message;
    EXPECT_EQ(result.angle_source, "joints");
    EXPECT_EQ(records(run, result).front().plane, "XY");
    // 0.01 um: the joints are interpolated between samples that lie 0.23 degrees apart.
    EXPECT_NEAR(value(run, result, "ovality_um"), 50.0, 0.01);
    EXPECT_NEAR(value(run, result, "ovality_axis_deg"), to_deg(0.3), 0.01);
    EXPECT_NEAR(value(run, result, "mean_radius_deviation_um"), 10.0, 0.01);
    EXPECT_NEAR(value(run, result, "circular_deviation_um"), 100.0, 0.1);
    EXPECT_NEAR(static_cast<double>(result.samples), 360.0 / (to_deg(0.05 / 0.1) * 0.004), 1.0);
  }
}

// The trap: a ball off by e leaves e^2/4R in the mean and in harmonic 2 of the plain deviation (metrology.md
// 2).
TEST(Process, AnEccentricBallIsNoOvality) {
  for (const double e_mm : {0.05, 0.5, 5.0}) {
    PlanarCircle circle;
    circle.ball_x = -e_mm * 1e-3 * std::cos(1.0);
    circle.ball_y = -e_mm * 1e-3 * std::sin(1.0);
    const ballbar::Run run = test::planar_run(circle);
    const RunResult result = result_of(circle);
    EXPECT_NEAR(value(run, result, "ovality_um"), 0.0, 1e-3 * e_mm + 1e-4) << e_mm << " mm";
    EXPECT_NEAR(value(run, result, "mean_radius_deviation_um"), 0.0, 1e-3 * e_mm + 1e-4) << e_mm << " mm";
    const Harmonic& first = result.circle->harmonics.front();
    EXPECT_NEAR(std::hypot(first.cos, first.sin), e_mm * 1e-3, 1e-9);
    EXPECT_NEAR(std::atan2(first.sin, first.cos), 1.0, 1e-5);
  }
}

TEST(Process, WithoutJointsTheAngleComesFromTime) {
  PlanarCircle circle;
  circle.shape = [](double a) { return 50e-6 * std::cos(2 * (a - 0.3)); };
  for (const int direction : {1, -1}) {
    circle.direction = direction;
    ballbar::Run run = test::planar_run(circle);
    run.joint_time.clear();
    run.joint_position.clear();
    const RunResult result = process(run, test::planar_test(circle), &planar());
    EXPECT_EQ(result.status, "ok") << result.message;
    EXPECT_EQ(result.angle_source, "time");
    EXPECT_NEAR(value(run, result, "ovality_um"), 50.0, 0.01);
    EXPECT_NEAR(value(run, result, "ovality_axis_deg"), to_deg(0.3), 0.02);
    run.feed = 0.0;  // not known: the rate comes from the run's own duration, with its margins of 20 ms
    EXPECT_NEAR(value(run, process(run, test::planar_test(circle), &planar()), "ovality_um"), 50.0, 0.05);
  }
}

TEST(Process, FindsTheDirectionInTheJoints) {
  PlanarCircle circle;
  circle.direction = -1;
  ballbar::Run run = test::planar_run(circle);
  run.direction = 0;
  EXPECT_EQ(process(run, test::planar_test(circle), &planar()).direction, -1);
  run.joint_time.clear();
  run.joint_position.clear();
  EXPECT_EQ(process(run, test::planar_test(circle), &planar()).status, "no_direction");
  run = test::planar_run(circle);
  run.direction = 1;
  EXPECT_EQ(process(run, test::planar_test(circle), &planar()).status, "wrong_direction");
}

TEST(Process, APartialArcGivesTheOrdersThatItCarries) {
  PlanarCircle circle;
  circle.arc_start_deg = -20;
  circle.arc_sweep_deg = 220;
  circle.overshoot_deg = 10;
  circle.shape = [](double a) { return 50e-6 * std::cos(2 * a); };
  const RunResult result = result_of(circle);
  ASSERT_TRUE(result.circle.has_value()) << result.message;
  EXPECT_EQ(result.status, "ok") << result.message;
  EXPECT_GE(result.circle->harmonics.size(), 2u);
  EXPECT_LT(result.circle->harmonics.size(), 30u);
  EXPECT_NEAR(ovality(*result.circle)->value, 50e-6, 0.05e-6);
}

TEST(Process, AnArcTooShortForItsCentreGivesWhatIsDefinedAndSaysWhatIsNot) {
  PlanarCircle circle;
  circle.arc_start_deg = 10;
  circle.arc_sweep_deg = 90;
  circle.overshoot_deg = 10;
  circle.ball_x = 20e-6;
  circle.shape = [](double a) { return 5e-6 + 2e-6 * std::sin(20 * a); };
  const ballbar::Run run = test::planar_run(circle);
  const RunResult result = result_of(circle);
  EXPECT_EQ(result.status, "ok");
  EXPECT_FALSE(result.circle);
  const std::map<std::string, Estimate> values = records(run, result).front().values;
  double longest = -1.0, shortest = 1.0;  // of the bar on the arc
  for (std::size_t i = result.arc_begin; i < result.arc_end; ++i) {
    longest = std::max(longest, run.bar_deviation[i]);
    shortest = std::min(shortest, run.bar_deviation[i]);
  }
  EXPECT_NEAR(values.at("radial_max_setup_um").value, longest * 1e6, 1e-6);
  EXPECT_NEAR(values.at("radial_min_setup_um").value, shortest * 1e6, 1e-6);
  EXPECT_NEAR(values.at("circular_error_um").value, 4.0, 0.3) << "the ripple alone";
  EXPECT_NEAR(values.at("start_angle_deg").value, 10.0, 0.2);
  EXPECT_NEAR(values.at("end_angle_deg").value, 100.0, 0.2);
  for (const char* missing :
       {"ovality_um", "eccentricity_um", "mean_radius_deviation_um", "circular_deviation_um",
        "roundness_lsc_um", "roundness_mzc_um", "roundness_mic_um", "roundness_mcc_um"})
    EXPECT_FALSE(values.contains(missing)) << missing;
  for (const char* named : {"ovality", "roundness_mic_um", "roundness_lsc_um", "too short", "not surround"})
    EXPECT_NE(result.message.find(named), std::string::npos) << named << " in: " << result.message;
  EXPECT_EQ(result.message.find("circular_error_um"), std::string::npos) << result.message;
}

/// The run the other way, as the store gives it back.
CircleTrace other_way_of(const ballbar::Run& run, const RunResult& result) {
  CircleTrace trace = measured_arc(result.angle, run.bar_deviation, result.arc_begin, result.arc_end);
  trace.direction = result.direction;
  trace.feed = run.feed;
  return trace;
}

TEST(Process, TheRunThatCompletesBothDirectionsHoldsTheirFigures) {
  // Radii + s 3 um, and an oval that turns with the direction by 8 um sin 2a: H = 6 + 16 um; a step of 12 um
  // where X turns round is 24 um of backlash.
  PlanarCircle circle;
  circle.ball_x = 30e-6;
  const auto shape = [](int s) {
    return [s](double a) {
      const double step = std::sin(a) >= 0.0 ? 12e-6 : -12e-6;
      return 4e-6 + s * 3e-6 + 20e-6 * std::cos(2 * a) + s * step * std::cos(a);
    };
  };
  circle.noise = [](int i) { return 0.1e-6 * std::sin(1.7 * i * i); };
  circle.shape = shape(1);
  const ballbar::Run ccw = test::planar_run(circle);
  const RunResult first = result_of(circle);
  EXPECT_FALSE(first.circle_test);
  circle.direction = -1;
  circle.shape = shape(-1);
  const ballbar::Run cw = test::planar_run(circle);
  const TestSpec test = test::planar_test(circle);
  const RunResult both = process(cw, test, &planar(), {{}, other_way_of(ccw, first)});
  ASSERT_TRUE(both.circle_test);
  EXPECT_EQ(both.message, "");
  const Record record = with_harmonics(records(cw, both).front(), both);
  const auto figure = [&](const char* name) { return record.values.at(name); };
  EXPECT_NEAR(figure("mean_bidirectional_radial_error_um").value, 4.0, 0.05);
  EXPECT_GT(figure("mean_bidirectional_radial_error_um").sd.value(), 0.0);
  EXPECT_NEAR(figure("hysteresis_um").value, 6.0 + 24.0, 0.5);
  EXPECT_GE(figure("circular_error_bidirectional_um").value, figure("circular_error_um").value);
  EXPECT_NEAR(figure("positional_tolerance_um").value, 2.0 * (4.0 + 3.0 + 20.0 + 12.0), 1.0);
  EXPECT_NEAR(figure("signature_backlash_x_um").value, 24.0, 0.3);
  EXPECT_GT(figure("signature_backlash_x_um").sd.value(), 0.0);
  EXPECT_NEAR(figure("signature_scaling_mismatch_ppm").value, 400.0, 4.0);  // R/2 a = 20 um
  // The same oval from X along the radius, which lies at atan2(0.1, 0.45) in this plane.
  const double turned = 2.0 * std::atan2(0.1, 0.45);
  EXPECT_NEAR(figure("radial_signature_scaling_mismatch_ppm").value, 400.0 * std::cos(turned), 40.0);
  for (const auto& [name, estimate] : record.values) EXPECT_TRUE(is_quantity(name, "circle")) << name;

  const RunResult alike = process(ccw, test, &planar(), {{}, other_way_of(ccw, first)});
  EXPECT_FALSE(alike.circle_test) << "the same way is no partner";
}

// 100 mm at 60 ppm/K and 25 degC: 30 um of the radius are warmth.
TEST(Process, R20TakesTheWarmthOffWhereATemperatureIsKnown) {
  PlanarCircle circle;
  circle.shape = [](double) { return 35e-6; };
  ballbar::Run run = test::planar_run(circle);
  TestSpec test = test::planar_test(circle);
  const auto figures = [&] { return records(run, process(run, test, &planar())).front().values; };
  EXPECT_FALSE(figures().contains("r20_deviation_um"));
  EXPECT_FALSE(figures().contains("expansion_ppm_k"));
  run.temperature = 25.0;
  EXPECT_NEAR(figures().at("r20_deviation_um").value, 35.0 - 5.85, 0.01) << "steel where nothing is said";
  EXPECT_TRUE(figures().at("r20_deviation_um").sd.has_value());
  EXPECT_NEAR(figures().at("expansion_ppm_k").value, 11.7, 1e-9);
  test.expansion = 60e-6;
  EXPECT_NEAR(figures().at("r20_deviation_um").value, 5.0, 0.02);
  run.virtual_bar = true;
  EXPECT_FALSE(figures().contains("r20_deviation_um")) << "joints do not grow";
}

TEST(Process, SaysWhereTheFeedWasNotTheProgrammedOne) {
  const PlanarCircle circle;  // driven at 50 mm/s
  ballbar::Run run = test::planar_run(circle);
  const TestSpec test = test::planar_test(circle);
  struct Row {
    double programmed;
    std::string message;
  };
  for (const auto& [programmed, message] :
       {Row{50.0, ""}, Row{52.0, ""}, Row{0.0, ""},
        Row{55.0, "driven at 50.0 mm/s, 9.1 % below the programmed 55.0 mm/s"},
        Row{45.0, "driven at 50.0 mm/s, 11.1 % above the programmed 45.0 mm/s"}}) {
    run.feed = programmed * 1e-3;
    const RunResult result = process(run, test, &planar());
    EXPECT_EQ(result.status, "ok") << programmed;
    EXPECT_EQ(result.message, message) << programmed;
    EXPECT_NEAR(value(run, result, "calculated_feed_mm_s"), 50.0, 1e-3) << programmed;
  }
  run.joint_time.clear();
  run.joint_position.clear();
  const RunResult timed = process(run, test, &planar());
  EXPECT_FALSE(records(run, timed).front().values.contains("calculated_feed_mm_s"))
      << "angles that were made with a feed tell of none";
}

TEST(Process, AFilterIsOfTheFiguresByIsoAndOfNoOther) {
  PlanarCircle circle;
  circle.shape = [](double a) { return 50e-6 * std::cos(2 * a) + 10e-6 * std::cos(90 * a); };
  const ballbar::Run run = test::planar_run(circle);
  TestSpec test = test::planar_test(circle);
  const auto figure = [&](const char* name) {
    return records(run, process(run, test, &planar())).front().values.at(name).value;
  };
  const double before = figure("circular_deviation_um");
  EXPECT_NEAR(figure("roundness_lsc_um"), 120.0, 0.5);
  test.filter_upr = 15.0;
  EXPECT_NEAR(figure("roundness_lsc_um"), 100.0 * std::exp2(-4.0 / 225.0), 0.2);
  EXPECT_EQ(figure("filter_upr"), 15.0);
  EXPECT_EQ(figure("circular_deviation_um"), before);
  test.filter_upr = 900.0;  // half a degree between samples
  const RunResult coarse = process(run, test, &planar());
  EXPECT_EQ(coarse.status, "ok");
  EXPECT_FALSE(coarse.circle_figures);
  EXPECT_NE(coarse.message.find("filter_upr"), std::string::npos);
}

TEST(Process, SaysWhenTheArcIsNotComplete) {
  PlanarCircle circle;
  ballbar::Run run = test::planar_run(circle);
  const auto third = static_cast<std::ptrdiff_t>(run.bar_time.size() / 3);
  run.bar_time.erase(run.bar_time.begin() + third, run.bar_time.begin() + third + 200);
  run.bar_deviation.erase(run.bar_deviation.begin() + third, run.bar_deviation.begin() + third + 200);
  EXPECT_EQ(process(run, test::planar_test(circle), &planar()).status, "arc_incomplete");
}

TEST(Process, AHoleInTheJointsIsNotBridged) {
  PlanarCircle circle;
  ballbar::Run run = test::planar_run(circle);
  const std::size_t from = run.joint_time.size() / 2;
  run.joint_time.erase(run.joint_time.begin() + static_cast<std::ptrdiff_t>(from),
                       run.joint_time.begin() + static_cast<std::ptrdiff_t>(from + 100));
  run.joint_position.erase(run.joint_position.begin() + static_cast<std::ptrdiff_t>(2 * from),
                           run.joint_position.begin() + static_cast<std::ptrdiff_t>(2 * (from + 100)));
  const RunResult result = process(run, test::planar_test(circle), &planar());
  EXPECT_EQ(result.status, "arc_incomplete") << result.message;
}

TEST(Process, TwoCirclesThatLostTheirMarksAreNotOne) {
  PlanarCircle circle;
  for (const int second : {1, -1}) {
    ballbar::Run run = test::planar_run(circle);
    PlanarCircle other = circle;
    other.direction = second;
    const ballbar::Run next = test::planar_run(other);
    const double shift = run.joint_time.back() + 3.0;
    for (const double t : next.bar_time) run.bar_time.push_back(t + shift);
    for (const double t : next.joint_time) run.joint_time.push_back(t + shift);
    run.bar_deviation.insert(run.bar_deviation.end(), next.bar_deviation.begin(), next.bar_deviation.end());
    run.joint_position.insert(run.joint_position.end(), next.joint_position.begin(),
                              next.joint_position.end());
    run.ended_us += std::llround(shift * 1e6);
    EXPECT_NE(process(run, test::planar_test(circle), &planar()).status, "ok") << "second " << second;
  }
}

TEST(Process, ACircleThatTheJointsDoNotDriveIsNotOk) {
  const PlanarCircle circle;
  const ballbar::Run run = test::planar_run(circle);
  TestSpec elsewhere = test::planar_test(circle);
  elsewhere.circle.centre[1] += 0.06;
  EXPECT_EQ(process(run, elsewhere, &planar()).status, "wrong_path");
  TestSpec larger = test::planar_test(circle);
  larger.circle.radius = 0.15;
  EXPECT_EQ(process(run, larger, &planar()).status, "wrong_path");
  TestSpec higher = test::planar_test(circle);
  higher.circle.centre[2] += 0.01;
  EXPECT_EQ(process(run, higher, &planar()).status, "wrong_path");
  TestSpec nearly = test::planar_test(circle);  // a tool length that is a little off
  nearly.circle.centre[1] += 0.001;
  EXPECT_EQ(process(run, nearly, &planar()).status, "ok");
}

TEST(Process, ADeviationOfHalfTheRadiusIsAWrongUnit) {
  PlanarCircle circle;
  ballbar::Run run = test::planar_run(circle);
  run.bar_deviation[1000] = -0.06;
  EXPECT_EQ(process(run, test::planar_test(circle), &planar()).status, "implausible");
}

TEST(Process, ALineWithoutSomeOfItsPointsIsIncomplete) {
  ballbar::Run run;
  run.kind = TestKind::kLine;
  TestSpec line;
  line.kind = TestKind::kLine;
  line.line.end = {0.0, 0.5, 0.0};
  for (int i = 0; i <= 10; ++i) run.readings.push_back({'X', 0.1 * i, 0.05 * i, 0.0});
  line.line.points = 11;
  EXPECT_EQ(process(run, line, nullptr).status, "ok");
  line.line.points = 12;
  EXPECT_EQ(process(run, line, nullptr).status, "line_incomplete");
  line.line.points = 0;
  EXPECT_EQ(process(run, line, nullptr).status, "ok");
  line.line.end = {0.0, 1.0, 0.0};
  EXPECT_EQ(process(run, line, nullptr).status, "line_incomplete");
}

TEST(Process, EveryEndHasItsWord) {
  PlanarCircle circle;
  const std::pair<RunEnd, std::string> table[] = {{RunEnd::kMark, "ok"},
                                                  {RunEnd::kAborted, "aborted"},
                                                  {RunEnd::kSilence, "no_end"},
                                                  {RunEnd::kNextBegin, "no_end"},
                                                  {RunEnd::kProducerRestart, "producer_restarted"},
                                                  {RunEnd::kInterrupted, "interrupted"},
                                                  {RunEnd::kMarksLost, "marks_lost"},
                                                  {RunEnd::kNoBegin, "no_begin"},
                                                  {RunEnd::kTooLong, "too_long"}};
  for (const auto& [end, word] : table) {
    ballbar::Run run = test::planar_run(circle);
    run.end = end;
    const RunResult result = process(run, test::planar_test(circle), &planar());
    EXPECT_EQ(result.status, word);
    const bool discarded =
        end == RunEnd::kAborted || end == RunEnd::kProducerRestart || end == RunEnd::kNoBegin;
    EXPECT_EQ(result.circle.has_value(), !discarded) << word;
  }
}

TEST(Process, ARunWithoutSamplesIsARowAllTheSame) {
  PlanarCircle circle;
  ballbar::Run run = test::planar_run(circle);
  run.bar_time.clear();
  run.bar_deviation.clear();
  const RunResult result = process(run, test::planar_test(circle), &planar());
  EXPECT_EQ(result.status, "too_few_samples");
  ASSERT_EQ(records(run, result).size(), 1u);
  EXPECT_EQ(records(run, result)[0].values.count("ovality_um"), 0u);
}

TEST(Process, RefusesNan) {
  PlanarCircle circle;
  ballbar::Run run = test::planar_run(circle);
  run.bar_deviation[5] = std::nan("");
  EXPECT_THROW(process(run, test::planar_test(circle), &planar()), std::invalid_argument);
}

TEST(Process, TheNoiseIsFoundAndTheStandardDeviationsAreTrue) {
  const unsigned seed = 11;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::normal_distribution<double> white(0.0, 2e-6);
  PlanarCircle circle;
  circle.shape = [](double a) { return 50e-6 * std::cos(2 * a); };
  circle.noise = [&](int) { return white(random); };
  double sum = 0.0;
  double square = 0.0;
  double stated = 0.0;
  const int repeats = 40;
  for (int i = 0; i < repeats; ++i) {
    const RunResult result = result_of(circle);
    EXPECT_NEAR(result.circle->noise, 2e-6, 0.15e-6);
    const double error = result.circle->harmonics[1].cos - 50e-6;
    sum += error;
    square += error * error;
    stated += result.circle->harmonics[1].var_cos;
  }
  const double spread = (square - sum * sum / repeats) / (repeats - 1);
  EXPECT_NEAR(spread / (stated / repeats), 1.0,
              0.7);  // chi-square of 39 degrees of freedom: 0.6 .. 1.5 in 95 %
}

TEST(Process, ALineGivesEachAxisItsStraightness) {
  ballbar::Run run;
  run.kind = TestKind::kLine;
  run.direction = -1;
  TestSpec line;
  line.kind = TestKind::kLine;
  for (int i = 0; i <= 10; ++i) {
    run.readings.push_back({'X', 0.1 * i, 0.05 * i, i == 5 ? 4e-6 : 0.0});
    run.readings.push_back({'Z', 0.1 * i, 0.05 * i, 1e-6 * i});
  }
  std::vector<LinePoint> other_way;
  for (int i = 0; i <= 10; ++i) other_way.push_back({0.05 * i, 3e-6, {}});
  const RunResult result = process(run, line, nullptr, {{{'X', other_way}}, {}});
  EXPECT_EQ(result.status, "ok");
  ASSERT_EQ(result.lines.size(), 2u);
  EXPECT_NEAR(result.lines[0].straightness_mz, 4e-6, 1e-15);
  ASSERT_TRUE(result.lines[0].reversal_max.has_value());
  EXPECT_NEAR(*result.lines[0].reversal_max, 3e-6, 1e-15);  // forward 3, backward 0
  EXPECT_NEAR(result.lines[1].straightness_mz, 0.0, 1e-15);
  EXPECT_NEAR(result.lines[1].slope_ls, 2e-5, 1e-12);
  EXPECT_FALSE(result.lines[1].reversal_max.has_value());
  EXPECT_EQ(records(run, result).size(), 2u);
}

TEST(Catalogue, NamesCarryTheirUnitAndAreFound) {
  for (const Quantity& q : catalogue()) {
    EXPECT_TRUE(is_quantity(q.name, q.kind == "run" ? "line" : q.kind)) << q.name;
    EXPECT_FALSE(q.meaning.empty());
  }
  EXPECT_TRUE(is_quantity("harmonic3_cos_um", "circle"));
  EXPECT_FALSE(is_quantity("harmonic31_um", "circle"));
  EXPECT_FALSE(is_quantity("harmonic3_mm", "circle"));
  EXPECT_TRUE(is_quantity("signature_squareness_um_per_m", "circle"));
  EXPECT_TRUE(is_quantity("radial_signature_servo_mismatch_ms", "circle"));
  EXPECT_FALSE(is_quantity("signature_servo_mismatch_um", "circle"));
  EXPECT_FALSE(is_quantity("signature_squareness_um_per_m", "line"));
  EXPECT_FALSE(is_quantity("ovality_um", "line"));
  EXPECT_FALSE(is_quantity("ovality_mm", "circle"));
}

TEST(Process, ALineOfImpossibleDeviationsGivesNoFigures) {
  TestSpec test;
  test.name = "Y";
  test.kind = TestKind::kLine;
  test.line = {{0.0, 0.0, 0.0}, {0.4, 0.0, 0.0}, 5};
  ballbar::Run run;
  run.kind = TestKind::kLine;
  run.direction = 1;
  for (int i = 0; i < 5; ++i) run.readings.push_back({'Y', 1.0 * i, 0.1 * i, i == 2 ? 1e194 : 1e-6});
  const RunResult result = process(run, test, nullptr);
  EXPECT_EQ(result.status, "implausible");
  EXPECT_TRUE(result.lines.empty());
}

}  // namespace
}  // namespace ballbar

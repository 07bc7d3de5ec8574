// Every line of both recordings of the paper, against what an independent script found in the same logs.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "metrology/line.hpp"
#include "support/paper_recording.hpp"

namespace ballbar {
namespace {

using nlohmann::json;

const std::filesystem::path kLinesFolder = std::filesystem::path(BALLBAR_SHARED_DIR) / "data" / "recordings";

double lines_um(double metres) { return metres * 1e6; }

LineResult analyse(const test::RecordedLine& run) {
  std::vector<InterferometerReading> readings;
  for (std::size_t i = 0; i < run.position.size(); ++i)
    readings.push_back({run.axis.at(0), 0.0, run.position[i], run.deviation[i]});
  return analyse_line(readings).value();
}

class PaperLines : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kLinesFolder)) GTEST_SKIP() << "no recordings at " << kLinesFolder;
    std::ifstream file(kLinesFolder / "expected.json");
    const json expected = json::parse(file);
    tolerances_ = expected.at("tolerances");
    lines_ = expected.at("recordings").at(GetParam()).at("lines");
    recording_ = test::read_paper_recording(kLinesFolder / GetParam());
  }
  double tolerance(const char* of) const { return tolerances_.at(of).get<double>(); }

  /// Points of the runs in one axis and direction.
  std::vector<std::vector<LinePoint>> runs(const std::string& axis, int direction) const {
    std::vector<std::vector<LinePoint>> found;
    for (const test::RecordedLine& run : recording_.lines)
      if (run.axis == axis && run.direction == direction) found.push_back(analyse(run).points);
    return found;
  }

  void expect_straightness(const std::optional<Straightness>& found, const json& expected) const {
    ASSERT_TRUE(found);
    EXPECT_NEAR(lines_um(found->mz), expected.at("minimum_zone_um"), tolerance("straightness_um"));
    EXPECT_NEAR(lines_um(found->ls), expected.at("least_squares_um"), tolerance("straightness_um"));
    EXPECT_NEAR(lines_um(found->ep), expected.at("end_points_um"), tolerance("straightness_um"));
    EXPECT_NEAR(lines_um(found->slope_ls), expected.at("least_squares_slope_um_per_m"),
                tolerance("slope_um_per_m"));
  }

  json tolerances_, lines_;
  test::PaperRecording recording_;
};

TEST_P(PaperLines, HaveTheExpectedStraightnessOfAllRunsAndOfEachWay) {
  for (const json& expected : lines_) {
    const std::string axis = expected.at("axis");
    SCOPED_TRACE(axis);
    const auto forward = runs(axis, 1);
    const auto backward = runs(axis, -1);
    EXPECT_EQ(forward.size() + backward.size(), expected.at("runs").get<std::size_t>());
    const LineBundle bundle = analyse_line_bundle(forward, backward);
    expect_straightness(bundle.all_runs, expected.at("all_runs"));
    expect_straightness(bundle.forward, expected.at("forward"));
    expect_straightness(bundle.forward_mean_of_runs, expected.at("forward_mean_of_runs"));
    expect_straightness(bundle.backward, expected.at("backward"));
    expect_straightness(bundle.backward_mean_of_runs, expected.at("backward_mean_of_runs"));
  }
}

TEST_P(PaperLines, HaveTheExpectedReversalAtEveryPoint) {
  for (const json& expected : lines_) {
    const std::string axis = expected.at("axis");
    SCOPED_TRACE(axis);
    const LineBundle bundle = analyse_line_bundle(runs(axis, 1), runs(axis, -1));
    ASSERT_EQ(bundle.forward_mean.size(), expected.at("points"));
    ASSERT_EQ(bundle.backward_mean.size(), expected.at("points"));
    const double of_reversal = tolerance("reversal_um");
    for (std::size_t i = 0; i < bundle.forward_mean.size(); ++i) {
      EXPECT_NEAR(bundle.forward_mean[i].position * 1e3, expected.at("position_mm").at(i),
                  tolerance("position_mm"));
      EXPECT_NEAR(lines_um(bundle.forward_mean[i].deviation), expected.at("mean_forward_um").at(i),
                  of_reversal);
      EXPECT_NEAR(lines_um(bundle.backward_mean[i].deviation), expected.at("mean_backward_um").at(i),
                  of_reversal);
      EXPECT_NEAR(lines_um(bundle.forward_mean[i].reversal.value()), expected.at("reversal_um").at(i),
                  of_reversal);
      EXPECT_NEAR(lines_um(bundle.backward_mean[i].reversal.value()), expected.at("reversal_um").at(i),
                  of_reversal);
    }
    EXPECT_NEAR(std::abs(lines_um(bundle.reversal_max.value())), expected.at("reversal_max_abs_um"),
                of_reversal);
    EXPECT_NEAR(lines_um(bundle.reversal_mean.value()), expected.at("reversal_mean_um"), of_reversal);
  }
}

TEST_P(PaperLines, HaveTheMeanOfTheFiveReversalsOfSingleRunsAsReversalOfTheMeans) {
  for (const json& expected : lines_) {
    const auto forward = runs(expected.at("axis"), 1);
    const auto backward = runs(expected.at("axis"), -1);
    ASSERT_EQ(forward.size(), backward.size());
    double mean = 0.0;
    for (std::size_t i = 0; i < forward.size(); ++i) {
      LineResult line;
      line.points = forward[i];
      add_reversal(line, 1, backward[i]);
      mean += lines_um(line.reversal_mean.value()) / static_cast<double>(forward.size());
    }
    EXPECT_NEAR(mean, expected.at("reversal_mean_um"), tolerance("reversal_um"));
  }
}

INSTANTIATE_TEST_SUITE_P(Both, PaperLines, testing::Values("paper-before.lcm", "paper-after.lcm"),
                         [](const auto& param) { return param.index == 0 ? "before" : "after"; });

}  // namespace
}  // namespace ballbar

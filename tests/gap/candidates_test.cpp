// Columns of every candidate against differences of the whole nonlinear model, on the paper's circle and a
// tilted one with payload.

#include "gap/candidates.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gap/observation.hpp"
#include "gap/paper_robot.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What was simulated as a run whose angles are known.
MeasuredRun measured(const SimulatedRun& simulated, double payload) {
  MeasuredRun one;
  ballbar::Run& run = one.run;
  run.robot = "lrmate-1";
  run.test = simulated.test;
  run.series = "s";
  run.direction = simulated.direction;
  run.repetition = simulated.repetition;
  run.payload = payload;
  run.feed = 0.05533;
  std::int64_t begin = -1;
  for (const Sample& sample : simulated.samples) {
    const SampleHeader& header =
        std::visit([](const auto& s) -> const SampleHeader& { return s.header; }, sample);
    if (begin < 0) begin = header.time_us;
    const double time = static_cast<double>(header.time_us - begin) * 1e-6;
    if (const auto* bar = std::get_if<BallbarBlock>(&sample)) {
      for (std::size_t i = 0; i < bar->deviation.size(); ++i) {
        run.bar_time.push_back(time + static_cast<double>(i) * bar->period);
        run.bar_deviation.push_back(bar->deviation[i]);
      }
    } else if (const auto* joints = std::get_if<JointSample>(&sample)) {
      run.joints = static_cast<int>(joints->position.size());
      run.joint_time.push_back(time);
      run.joint_position.insert(run.joint_position.end(), joints->position.begin(), joints->position.end());
    }
    run.ended_us = header.time_us;
  }
  run.started_us = begin;
  // The simulation knows the commanded angle of each reading on the arc; they are the last that begin there.
  one.angle.assign(run.bar_time.size(), std::nan(""));
  for (std::size_t i = 0;
       i + static_cast<std::size_t>(simulated.deviation.size()) <= run.bar_deviation.size(); ++i) {
    bool same = true;
    for (Index k = 0; same && k < 20; ++k)
      same = run.bar_deviation[i + static_cast<std::size_t>(k)] == simulated.deviation[k];
    if (!same) continue;
    one.arc_begin = i;
    one.arc_end = i + static_cast<std::size_t>(simulated.angle.size());
    for (Index k = 0; k < simulated.angle.size(); ++k)
      one.angle[i + static_cast<std::size_t>(k)] = simulated.angle[k];
    break;
  }
  return one;
}

class CandidateColumns : public testing::Test {
 protected:
  void SetUp() override {
    TestSpec flat = test::paper_circle("A");
    flat.payload = 0.438;
    TestSpec tilted = test::paper_circle("T");
    tilted.circle.normal = {-0.5, 0.0, std::sqrt(0.75)};
    tilted.circle.first_axis = {std::sqrt(0.75), 0.0, 0.5};
    tilted.tool_rpy = Vec3{test::kDeg * 180.0, -test::kDeg * 30.0, 0.0};
    tilted.payload = 3.0;
    spec_ = test::paper_robot({flat, tilted}, {});
    spec_.payload_com = {0.0, 0.0, 0.05};
    spec_.gear_ratio = {120, 121, 100, 80, 80, 50};
    std::vector<MeasuredRun> runs;
    for (const SimulatedRun& run : test::simulated(spec_, {}))
      runs.push_back(measured(run, run.test == "A" ? 0.438 : 3.0));
    model_.emplace(AsBuilt(test::lrmate(), spec_), spec_);
    observations_ = observe(std::move(runs), spec_, model_->model());
    ASSERT_EQ(observations_.all.size(), 4u) << "both directions of both";
    ASSERT_TRUE(observations_.left_aside.empty());
  }

  RobotSpec spec_;
  std::optional<GapModel> model_;
  Observations observations_;
};

TEST_F(CandidateColumns, AreDifferencesOfTheWholeModel) {
  const std::vector<Candidate> candidates = candidates_for(*model_, observations_.all);
  ASSERT_GT(candidates.size(), 60u);
  for (std::size_t i = 0; i < observations_.all.size(); ++i) {
    const Observation& seen = observations_.all[i];
    GapState state = model_->start(observations_.all);
    state.zero[1] = 1e-3;
    state.zero[3] = -1e-3;
    const Tangent at = model_->tangent(model_->built(state), seen, i, state);
    Drive drive = at.drive();
    for (const Candidate& candidate : candidates) {
      SCOPED_TRACE(seen.test + (seen.direction > 0 ? "+1 " : "-1 ") + candidate.label());
      const MatrixXd columns = columns_of(*model_, at, drive, candidate, {}, Slope::kChord);
      for (Index k = 0; k < columns.cols(); ++k) {
        // Patterns that hang on their size are followed at that size; the rest near none.
        const double size = candidate.curved ? 1.0 : 0.02;
        GapState with = state;
        with.effects.push_back(candidate.with(size * VectorXd::Unit(columns.cols(), k)));
        const VectorXd moved = model_->predict(model_->built(with), seen, i, with) - at.predicted;
        // Second order: a typical size moves the tool by less than 1 mm, on 400 mm of arm and 100 mm of bar.
        const double allowed = 0.02 * columns.col(k).cwiseAbs().maxCoeff() + 2e-9 / size;
        EXPECT_LT((moved / size - columns.col(k)).cwiseAbs().maxCoeff(), allowed);
      }
    }
  }
}

TEST_F(CandidateColumns, ObservationsKeepTheReadings) {
  // What the bar read, from its coefficients back at the places, against the exact distances there.
  for (std::size_t i = 0; i < observations_.all.size(); ++i) {
    const Observation& seen = observations_.all[i];
    GapState state = model_->start(observations_.all);
    const VectorXd predicted = model_->predict(model_->built(state), seen, i, state);
    const VectorXd difference = seen.measured - seen.transform(predicted);
    EXPECT_LT(difference.norm() / std::sqrt(static_cast<double>(seen.places())), 20e-9) << seen.test;
  }
}

}  // namespace
}  // namespace ballbar

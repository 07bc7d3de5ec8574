#include "pipeline/recognition.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kinematics/inverse.hpp"
#include "metrology/recogniser.hpp"

namespace ballbar {
namespace {

class JointRecogniser : public Recogniser {
 public:
  JointRecogniser(RobotModel model, std::vector<std::size_t> tests, std::vector<CircleToRecognise> circles)
      : model_(std::move(model)), tests_(std::move(tests)), circles_(std::move(circles)) {}

  void take(std::int64_t time_us, std::span<const double> q, std::vector<RecognisedCircle>& found) override {
    const bool fits = q.size() == static_cast<std::size_t>(model_.joints()) &&
                      std::all_of(q.begin(), q.end(), [](double angle) { return std::isfinite(angle); });
    if (!fits) return end_path(found);
    const std::size_t before = found.size();
    circles_.take(time_us, model_.forward(q), found);
    name_tests(found, before);
  }
  void end_path(std::vector<RecognisedCircle>& found) override {
    const std::size_t before = found.size();
    circles_.end_path(found);
    name_tests(found, before);
  }
  void reset() override { circles_.reset(); }
  std::optional<std::int64_t> needed_since_us() const override { return circles_.needed_since_us(); }

 private:
  /// The robot's tests, among which there may be lines.
  void name_tests(std::vector<RecognisedCircle>& found, std::size_t from) const {
    for (; from < found.size(); ++from) found[from].test = tests_[found[from].test];
  }

  RobotModel model_;
  std::vector<std::size_t> tests_;
  CircleRecogniser circles_;
};

}  // namespace

std::unique_ptr<Recogniser> make_recogniser(const RobotSpec& robot, const RobotModel& model) {
  std::vector<std::size_t> tests;
  std::vector<CircleToRecognise> circles;
  for (std::size_t i = 0; i < robot.tests.size(); ++i) {
    const TestSpec& test = robot.tests[i];
    if (test.kind != TestKind::kCircle) continue;
    CircleToRecognise& circle = circles.emplace_back();
    circle.circle = test.circle;
    circle.feed = test.feed;
    if (test.tool_rpy) circle.tool = tool_pose(test.circle.centre, *test.tool_rpy).linear();
    tests.push_back(i);
  }
  if (circles.empty()) return nullptr;
  return std::make_unique<JointRecogniser>(model, std::move(tests), std::move(circles));
}

}  // namespace ballbar

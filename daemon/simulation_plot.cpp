#include <cstdio>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/service.hpp"
#include "daemon/simulation.hpp"

namespace ballbar {
namespace {

constexpr Eigen::Index kMotionPoints = 400;  // of a joint's curve: smooth on any screen

std::string note(const SimulatedRun& run, const std::string& name) {
  char text[120];
  std::snprintf(text, sizeof text, "%s: mean %.1f um, from the shortest to the longest bar %.1f um",
                name.c_str(), to_um(run.deviation.mean()),
                to_um(run.deviation.maxCoeff() - run.deviation.minCoeff()));
  return text;
}

}  // namespace

std::string SimulationPlot::joints_path(const std::string& path) {
  const std::size_t dot = path.rfind('.');
  const std::string ending = dot == std::string::npos ? "" : path.substr(dot);
  if (ending != ".svg" && ending != ".png")
    throw Error(Cause::kInput, path + ": a picture's name ends in .svg or .png");
  return path.substr(0, dot) + "-joints" + ending;
}

void SimulationPlot::add(const SimulatedRun& simulated) {
  const std::string name = run_name(simulated.test, simulated.direction, simulated.repetition);
  const bool circle = simulated.kind == TestKind::kCircle;
  if (circle ? !line_.traces.empty() : !polar_.traces.empty())
    throw Error(Cause::kInput, "circles and lines do not go into one plot; choose one kind with --test");
  if (motion_.joints.empty()) add_motion(simulated);
  if (simulated.repetition == 1 &&
      (", " + tests_ + ",").find(", " + simulated.test + ",") == std::string::npos)
    tests_ += (tests_.empty() ? "" : ", ") + simulated.test;
  if (circle) {
    PolarTrace& trace = polar_.traces.emplace_back();
    trace.label = name;
    trace.direction = simulated.direction;
    for (Eigen::Index i = 0; i < simulated.angle.size(); ++i) {
      trace.angle_rad.push_back(simulated.angle[i]);
      trace.deviation_um.push_back(to_um(simulated.deviation[i]));
    }
    polar_.notes.push_back(note(simulated, name));
  } else if (simulated.repetition == 1) {
    std::map<char, LineTrace> traces;
    for (const Sample& sample : simulated.samples)
      if (const auto* block = std::get_if<InterferometerBlock>(&sample)) {
        traces[block->axis].position_mm.push_back(to_mm(block->position.front()));
        traces[block->axis].deviation_um.push_back(to_um(block->deviation.front()));
      }
    for (auto& [axis, trace] : traces) {
      trace.label = name + " " + std::string(1, axis);
      trace.direction = simulated.direction;
      line_.traces.push_back(std::move(trace));
    }
  }
}

void SimulationPlot::add_motion(const SimulatedRun& simulated) {
  const CommandedPath& path = *simulated.commanded;
  const bool circle = simulated.kind == TestKind::kCircle;
  motion_.title = robot_.name + "   joints on test " + simulated.test;
  motion_.subtitle = "commanded, " + std::string(robot_.joint_convention == JointConvention::kFanuc
                                                     ? "J3 as on the teach pendant"
                                                     : "angles of the URDF");
  motion_.place_label = circle ? "angle on the circle [deg]" : "position along the line [mm]";
  motion_.joints.resize(static_cast<std::size_t>(model_.joints()));
  const Eigen::Index step = 1 + path.motion.time.size() / kMotionPoints;
  for (Eigen::Index i = 0; i < path.motion.time.size(); i += step) {
    std::vector<double> q(path.motion.q.col(i).begin(), path.motion.q.col(i).end());
    model_.from_chain(q);
    for (std::size_t j = 0; j < q.size(); ++j) {
      motion_.joints[j].label = "J" + std::to_string(j + 1);
      motion_.joints[j].place.push_back(circle ? to_deg(path.angle[i]) : to_mm(path.position[i]));
      motion_.joints[j].angle_deg.push_back(to_deg(q[j]));
    }
  }
}

void SimulationPlot::render(const std::string& path, const std::string& series) const {
  const std::string joints = joints_path(path);
  const std::string title = robot_.name + "   test " + tests_;
  if (line_.traces.empty()) {
    PolarPlot plot = polar_;
    plot.title = title;
    plot.subtitle = series;
    ballbar::render(polar_script(plot), path);
  } else {
    LinePlot plot = line_;
    plot.title = title;
    plot.subtitle = series;
    ballbar::render(line_script(plot), path);
  }
  ballbar::render(motion_script(motion_), joints);
}

}  // namespace ballbar

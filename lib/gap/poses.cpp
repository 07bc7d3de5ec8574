#include "gap/poses.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

#include "core/error.hpp"

namespace ballbar {
namespace {

using Eigen::Index;

constexpr double kSameAngle = 1e-7;  // [rad] 6e-6 deg: a pose that was not left
constexpr double kMoved = 1.75e-5;   // [rad] a thousandth of a degree
constexpr double kMovingStep = 0.1;  // [s] rows closer than this in time are samples of a motion
constexpr double kStandstill = 1e6;  // [s] between poses for what asks for times: nothing accelerates
constexpr int kFewestRows = 8;

bool held_out_by_name(const std::string& series) {
  const std::string end = "-held-out";
  return series.size() >= end.size() && series.compare(series.size() - end.size(), end.size(), end) == 0;
}

int number_of(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  names.push_back(name);
  return static_cast<int>(names.size()) - 1;
}

JointVector chain_angles(const RobotModel& model, const std::vector<double>& joints) {
  if (static_cast<int>(joints.size()) != model.joints())
    throw std::invalid_argument("poses: another number of joints than the robot has");
  JointVector q = Eigen::Map<const Eigen::VectorXd>(joints.data(), model.joints());
  model.to_chain({q.data(), joints.size()});
  return q;
}

PoseRow row_of(const Pose& pose, const RobotModel& model, std::size_t count) {
  PoseRow row;
  row.q = chain_angles(model, pose.joints);
  for (JointVector* each : {&row.known, &row.torque, &row.move, &row.approach, &row.command, &row.speed})
    *each = JointVector::Zero(model.joints());
  if (!pose.command.empty()) row.command = chain_angles(model, pose.command) - row.q;
  row.point = Eigen::Vector3d(pose.point[0], pose.point[1], pose.point[2]);
  row.length = pose.length;
  row.direction = pose.direction;
  row.time = pose.time.value_or(0.0);
  row.order = static_cast<double>(pose.row - 1) / static_cast<double>(std::max<std::size_t>(1, count - 1));
  row.row = pose.row;
  row.held_out = pose.held_out;
  return row;
}

bool same_place(const PoseRow& one, const PoseRow& other) {
  return (one.q - other.q).cwiseAbs().maxCoeff() < kSameAngle &&
         (one.command - other.command).cwiseAbs().maxCoeff() < kSameAngle;
}

bool repeats(const PoseRow& one, const PoseRow& other, const Pose& a, const Pose& b) {
  return one.frame == other.frame && one.tool == other.tool && one.direction == other.direction &&
         a.payload == b.payload && one.held_out == other.held_out && same_place(one, other);
}

/// Moves, approach and speed come from the sequence before repeats are averaged.
void add_moves(PoseRows& rows) {
  std::vector<const PoseRow*> before(rows.tools.size(), nullptr), last_stand(rows.tools.size(), nullptr);
  for (PoseRow& row : rows.rows) {
    const auto t = static_cast<std::size_t>(row.tool);
    if (before[t] != nullptr) {
      const JointVector step = row.q - before[t]->q;
      // A repeat of the pose arrived as the first of them did.
      row.move = step.cwiseAbs().maxCoeff() < kSameAngle ? before[t]->move : step;
      for (Index j = 0; j < row.move.size(); ++j)
        row.approach[j] =
            std::abs(row.move[j]) > kMoved ? std::copysign(1.0, row.move[j]) : before[t]->approach[j];
    }
    before[t] = &row;
  }
}

void add_speeds(PoseRows& rows) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < rows.rows.size(); ++i)
    if (rows.rows[i].tool == rows.rows[i - 1].tool)
      steps.push_back(rows.rows[i].time - rows.rows[i - 1].time);
  if (!rows.timed || steps.size() < 4) return;
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  const double step = steps[steps.size() / 2];
  rows.moving = step > 0.0 && step < kMovingStep;
  if (!rows.moving) return;
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const bool first = i == 0 || rows.rows[i - 1].tool != rows.rows[i].tool;
    const bool last = i + 1 == rows.rows.size() || rows.rows[i + 1].tool != rows.rows[i].tool;
    const PoseRow &a = rows.rows[first ? i : i - 1], &b = rows.rows[last ? i : i + 1];
    const double time = b.time - a.time;
    if (time > 0.0 && time < 5.0 * step) rows.rows[i].speed = (b.q - a.q) / time;
  }
}

/// Neighbours that repeat one pose become one row; their scatter is the noise.
void average_repeats(PoseRows& rows, const std::vector<Pose>& poses) {
  std::vector<PoseRow> averaged;
  double squares = 0.0;
  const std::vector<PoseRow>& all = rows.rows;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    while (!rows.moving && end < all.size() && repeats(all[i], all[end], poses[i], poses[end])) ++end;
    PoseRow row = all[i];
    row.repeats = static_cast<int>(end - i);
    row.point.setZero();
    row.length = row.time = 0.0;
    for (std::size_t k = i; k < end; ++k) {
      row.point += all[k].point / row.repeats;
      row.length += all[k].length / row.repeats;
      row.time += all[k].time / row.repeats;
    }
    for (std::size_t k = i; k < end; ++k)
      squares +=
          rows.lengths ? std::pow(all[k].length - row.length, 2) : (all[k].point - row.point).squaredNorm();
    rows.repeat_dof += (row.repeats - 1) * rows.per_row();
    averaged.push_back(row);
    i = end;
  }
  if (rows.repeat_dof > 0) rows.repeat_sd = std::sqrt(squares / rows.repeat_dof);
  rows.rows = std::move(averaged);
}

void number_places(PoseRows& rows) {
  std::map<std::vector<long long>, int> places;
  for (PoseRow& row : rows.rows) {
    std::vector<long long> key;
    for (Index j = 0; j < row.q.size(); ++j) key.push_back(std::llround(row.q[j] / (10.0 * kSameAngle)));
    row.place = places.emplace(key, static_cast<int>(places.size())).first->second;
  }
  rows.places = static_cast<int>(places.size());
}

/// Effects of a joint's angle that a pose can show; geometry is in AsBuilt::chain().
bool static_effect(const Effect& effect) {
  const EffectKind& kind = *effect.kind;
  return (kind.deflection != nullptr && kind.name != "joint_lost_motion") ||
         (kind.geometry != nullptr && kind.growth == nullptr);
}

void add_known(PoseRows& rows, const std::vector<Pose>& poses, const AsBuilt& robot, const RobotSpec& spec) {
  for (const Effect& effect : robot.effects())
    if (!static_effect(effect)) rows.not_applied.emplace_back(effect.kind->name);
  const RobotModel& model = robot.model();
  const std::vector<Body>& bodies = model.bodies();
  std::optional<Body> payload;
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    PoseRow& row = rows.rows[i];
    Conditions conditions;
    conditions.payload = poses[i].payload.value_or(spec.payload);
    std::vector<Body> carried = bodies;
    if (conditions.payload > 0.0) {
      if (!payload)
        payload =
            model.payload(1.0, {spec.payload_com[0], spec.payload_com[1], spec.payload_com[2]}, "tool0");
      carried.push_back(*payload);
      carried.back().mass = conditions.payload;
    }
    const std::span<const double> q(row.q.data(), static_cast<std::size_t>(row.q.size()));
    row.torque = gravity_torques(robot.chain(), carried, q);
    if (robot.nominal()) continue;
    Motion stand;  // long enough to stand still in every sense
    stand.time = Eigen::VectorXd::LinSpaced(5, 0.0, 4.0 * kStandstill);
    stand.q = row.q.replicate(1, 5);
    row.known = robot.link_angles(stand, conditions).col(2) - row.q;
  }
}

}  // namespace

PoseRows prepare_poses(const PoseSet& set, const AsBuilt& robot, const RobotSpec& spec,
                       const std::vector<std::string>& series_held_out) {
  PoseRows rows;
  rows.lengths = set.lengths;
  rows.timed =
      std::all_of(set.poses.begin(), set.poses.end(), [](const Pose& p) { return p.time.has_value(); });
  rows.commanded =
      std::any_of(set.poses.begin(), set.poses.end(), [](const Pose& p) { return !p.command.empty(); });
  std::set<int> directions;
  for (const Pose& pose : set.poses) {
    PoseRow row = row_of(pose, robot.model(), set.poses.size());
    row.frame = number_of(rows.frames, pose.series);
    row.tool = number_of(rows.tools, pose.tool.empty() ? pose.series : pose.series + ":" + pose.tool);
    rows.rows.push_back(row);
    directions.insert(pose.direction);
  }
  rows.directed = directions.count(1) > 0 && directions.count(-1) > 0;
  for (const std::string& series : series_held_out)
    if (std::find(rows.frames.begin(), rows.frames.end(), series) == rows.frames.end())
      throw Error(Cause::kInput, "--hold-out: no row is of series '" + series + "'");
  for (const std::string& frame : rows.frames)
    rows.frame_held_out.push_back(held_out_by_name(frame) ||
                                  std::find(series_held_out.begin(), series_held_out.end(), frame) !=
                                      series_held_out.end());
  for (PoseRow& row : rows.rows)
    row.held_out = row.held_out || rows.frame_held_out[static_cast<std::size_t>(row.frame)];
  if (rows.timed) {
    double first = rows.rows.front().time;
    for (const PoseRow& row : rows.rows) first = std::min(first, row.time);
    for (PoseRow& row : rows.rows) row.time -= first;
  }
  add_moves(rows);
  add_speeds(rows);
  add_known(rows, set.poses, robot, spec);
  average_repeats(rows, set.poses);
  number_places(rows);
  const auto fitted =
      std::count_if(rows.rows.begin(), rows.rows.end(), [](const PoseRow& r) { return !r.held_out; });
  if (fitted < kFewestRows)
    throw Error(Cause::kInput, std::to_string(fitted) + " different poses are left to be fitted; at least " +
                                   std::to_string(kFewestRows) + " are needed");
  return rows;
}

std::vector<bool> hold_out_blocks(const PoseRows& rows, int part, int parts) {
  // Places, not rows: the same joint angles on both sides would be no proof.
  std::vector<int> order(static_cast<std::size_t>(rows.places), -1);
  int next = 0;
  for (const PoseRow& row : rows.rows)
    if (order[static_cast<std::size_t>(row.place)] < 0) order[static_cast<std::size_t>(row.place)] = next++;
  std::vector<bool> held;
  held.reserve(rows.rows.size());
  for (const PoseRow& row : rows.rows)
    held.push_back(static_cast<long long>(order[static_cast<std::size_t>(row.place)]) * parts / rows.places ==
                   part);
  return held;
}

std::vector<bool> hold_out_random(const PoseRows& rows, int part, int parts, unsigned seed) {
  std::vector<int> order(static_cast<std::size_t>(rows.places));
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(seed);
  for (std::size_t i = order.size(); i > 1; --i)  // not std::shuffle: its sequence is the library's own
    std::swap(order[i - 1], order[random() % i]);
  std::vector<bool> held;
  held.reserve(rows.rows.size());
  for (const PoseRow& row : rows.rows)
    held.push_back(static_cast<long long>(order[static_cast<std::size_t>(row.place)]) * parts / rows.places ==
                   part);
  return held;
}

PoseCoverage pose_coverage(const std::vector<PoseRow>& fitted, const std::vector<PoseRow>& held_out,
                           double slack) {
  PoseCoverage coverage;
  if (fitted.empty() || held_out.empty()) return coverage;
  JointVector least = fitted.front().q, most = fitted.front().q;
  for (const PoseRow& row : fitted) {
    least = least.cwiseMin(row.q);
    most = most.cwiseMax(row.q);
  }
  std::vector<bool> outside(held_out.size(), false);
  for (Index j = 0; j < least.size(); ++j) {
    PoseCoverage::Joint joint{static_cast<int>(j) + 1, 0, least[j], most[j], held_out.front().q[j],
                              held_out.front().q[j]};
    for (std::size_t i = 0; i < held_out.size(); ++i) {
      const double q = held_out[i].q[j];
      joint.least = std::min(joint.least, q);
      joint.most = std::max(joint.most, q);
      if (q >= least[j] - slack && q <= most[j] + slack) continue;
      ++joint.outside;
      outside[i] = true;
    }
    if (joint.outside > 0) coverage.joints.push_back(joint);
  }
  coverage.outside = static_cast<int>(std::count(outside.begin(), outside.end(), true));
  return coverage;
}

}  // namespace ballbar

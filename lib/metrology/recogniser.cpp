#include "metrology/recogniser.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace ballbar {
namespace {

constexpr double kToolOff = 2.0 * kRadPerDeg;
constexpr double kRestMove = 1e-4;          // [m]
constexpr std::int64_t kRestUs = 500'000;   // standing still: no further than that for so long
constexpr double kEdge = 0.5 * kRadPerDeg;  // a robot stops this near to the end of an arc,
constexpr double kEdgeShare = 0.005;        // and not further than this share of its sweep
constexpr double kRounding = 1e-9;          // [rad] a path that ends there, ends there
constexpr double kSameSweep = 1.0 * kRadPerDeg;
constexpr double kTouching = 0.1;  // arcs that overlap by a smaller share of the time follow one another
const double kFeedFits = std::log(1.2);
constexpr double kFastest = 10.0;  // [m/s] no robot drives circles faster
constexpr int kLeastSamples = 10;

constexpr std::array<int, 2> kDirections = {1, -1};

std::size_t way_of(int direction) { return direction > 0 ? 0 : 1; }

double edge_of(const CircleSpec& circle) { return std::min(kEdge, kEdgeShare * circle.arc_sweep); }

/// Where an arc begins, along the way.
double arc_begin(const CircleSpec& circle, int direction) {
  return direction > 0 ? circle.arc_start : -(circle.arc_start + circle.arc_sweep);
}

/// By how much one time span lies within another, at least; the end may not be known yet.
bool overlap(std::int64_t begin, std::int64_t end, std::int64_t other_begin,
             std::optional<std::int64_t> other_end) {
  const double common =
      static_cast<double>(std::min(end, other_end.value_or(end)) - std::max(begin, other_begin));
  return common > kTouching * static_cast<double>(end - begin);
}

/// How far a feed is from the configured one. A test without feed comes behind those that it fits.
double feed_off(double driven, double configured) {
  if (!(configured > 0.0) || !(driven > 0.0)) return kFeedFits;
  return std::abs(std::log(driven / configured));
}

}  // namespace

void CircleRecogniser::CircleSums::add(double x, double y) {
  const Eigen::Vector3d row(2.0 * x, 2.0 * y, 1.0);
  normal += row * row.transpose();
  right += row * (x * x + y * y);
  ++count;
}

CircleRecogniser::CircleRecogniser(std::vector<CircleToRecognise> tests) {
  for (CircleToRecognise& test : tests) {
    Track& track = tracks_.emplace_back();
    track.plane = plane_of(test.circle);
    track.test = std::move(test);
  }
}

void CircleRecogniser::take(std::int64_t time_us, const Eigen::Isometry3d& X_BT,
                            std::vector<RecognisedCircle>& found) {
  if (last_us_ && time_us <= *last_us_) return;
  if (last_us_ && static_cast<double>(time_us - *last_us_) * kSecondsPerUs > kLongestJointGap)
    end_path(found);
  const Eigen::Vector3d point = X_BT.translation();
  if (!last_us_ || (point - anchor_.point).norm() > kRestMove) anchor_ = {time_us, point};
  last_us_ = time_us;
  const bool resting = time_us - anchor_.time_us > kRestUs;
  for (std::size_t i = 0; i < tracks_.size(); ++i) follow(i, time_us, X_BT, resting);
  hand_on(found);
}

void CircleRecogniser::end_path(std::vector<RecognisedCircle>& found) {
  for (std::size_t i = 0; i < tracks_.size(); ++i) end_track(i);
  hand_on(found);
  last_us_.reset();
}

void CircleRecogniser::reset() {
  for (Track& track : tracks_) {
    track.on_circle = false;
    for (Way& way : track.ways) way.laps.clear();
  }
  done_.clear();
  last_us_.reset();
}

std::optional<std::int64_t> CircleRecogniser::needed_since_us() const {
  std::optional<std::int64_t> since;
  const auto need = [&since](std::int64_t begin_us) { since = std::min(since.value_or(begin_us), begin_us); };
  for (const Track& track : tracks_)
    for (const Way& way : track.ways)
      for (const Lap& lap : way.laps) need(lap.begin_us);
  for (const Done& done : done_) need(done.circle.begin_us);
  return since;
}

void CircleRecogniser::follow(std::size_t index, std::int64_t time_us, const Eigen::Isometry3d& X_BT,
                              bool resting) {
  Track& track = tracks_[index];
  const CircleSpec& circle = track.test.circle;
  const Eigen::Vector3d arm = X_BT.translation() - track.plane.centre;
  const double x = arm.dot(track.plane.e1);
  const double y = arm.dot(track.plane.e2);
  bool on_circle = std::abs(arm.dot(track.plane.normal)) < kOffPath &&
                   std::abs(std::hypot(x, y) - circle.radius) < kOffPath;
  if (on_circle && track.test.tool) {
    const double cosine = ((track.test.tool->transpose() * X_BT.linear()).trace() - 1.0) / 2.0;
    on_circle = cosine > std::cos(kToolOff);
  }
  if (!on_circle) return end_track(index);
  double angle = std::atan2(y, x);
  if (track.on_circle) angle += kTurn * std::round((track.angle - angle) / kTurn);
  if (resting || (track.on_circle && std::abs(angle - track.angle) > kLargestHole)) end_track(index);
  track.angle = angle;
  for (const int direction : kDirections) {
    if (track.on_circle)
      advance(index, direction, direction * angle, time_us);
    else
      restart(index, direction, direction * angle, time_us);
    for (Lap& lap : track.ways[way_of(direction)].laps) lap.path.add(x / circle.radius, y / circle.radius);
  }
  track.on_circle = true;
}

/// A one-way stretch begins here.
void CircleRecogniser::restart(std::size_t index, int direction, double angle, std::int64_t time_us) {
  const CircleSpec& circle = tracks_[index].test.circle;
  Way& way = tracks_[index].ways[way_of(direction)];
  const double first = arc_begin(circle, direction);
  way.start = angle;
  way.furthest = angle;
  way.next_arc = first + kTurn * std::ceil((angle - edge_of(circle) - first) / kTurn);
  way.laps.clear();
  advance(index, direction, angle, time_us);
}

void CircleRecogniser::advance(std::size_t index, int direction, double angle, std::int64_t time_us) {
  const CircleSpec& circle = tracks_[index].test.circle;
  Way& way = tracks_[index].ways[way_of(direction)];
  if (angle < way.start || way.furthest - angle > kBackwards) {
    end_way(index, direction);
    return restart(index, direction, angle, time_us);
  }
  if (angle > way.furthest || way.laps.empty()) {
    way.furthest = std::max(way.furthest, angle);
    way.furthest_us = time_us;
  }
  for (; way.next_arc - circle.overshoot - kRounding <= angle; way.next_arc += kTurn) {
    Lap& lap = way.laps.emplace_back();
    lap.arc = way.next_arc;
    lap.begin_us = time_us;
  }
  for (Lap& lap : way.laps) {
    if (!lap.arc_begin_us && angle >= lap.arc - kRounding) {
      lap.arc_begin_us = time_us;
      lap.arc_from = angle;
    }
    if (!lap.arc_end_us && angle >= lap.arc + circle.arc_sweep - edge_of(circle)) {
      lap.arc_end_us = time_us;
      lap.arc_to = angle;
    }
  }
  const auto over = [&](const Lap& lap) {
    return angle >= lap.arc + circle.arc_sweep + circle.overshoot - kRounding;
  };
  for (const Lap& lap : way.laps)
    if (over(lap)) finish(index, direction, lap, time_us);
  std::erase_if(way.laps, over);
}

void CircleRecogniser::end_way(std::size_t index, int direction) {
  Way& way = tracks_[index].ways[way_of(direction)];
  for (const Lap& lap : way.laps)
    if (lap.arc_end_us) finish(index, direction, lap, way.furthest_us);
  way.laps.clear();
}

void CircleRecogniser::end_track(std::size_t index) {
  for (const int direction : kDirections) end_way(index, direction);
  tracks_[index].on_circle = false;
}

void CircleRecogniser::finish(std::size_t index, int direction, const Lap& lap, std::int64_t end_us) {
  const Track& track = tracks_[index];
  if (!lap.arc_begin_us || !lap.arc_end_us || !driven_as_configured(track, lap)) return;
  const double duration = static_cast<double>(*lap.arc_end_us - *lap.arc_begin_us) * kSecondsPerUs;
  const double way = track.test.circle.radius * (lap.arc_to - lap.arc_from);
  if (way > kFastest * duration) return;
  Done& done = done_.emplace_back();
  done.circle = {index, direction, lap.begin_us, end_us, way / duration};
  done.arc_begin_us = *lap.arc_begin_us;
  done.arc_end_us = *lap.arc_end_us;
}

bool CircleRecogniser::driven_as_configured(const Track& track, const Lap& lap) const {
  if (lap.path.count < kLeastSamples) return false;
  const Eigen::Vector3d circle = lap.path.normal.ldlt().solve(lap.path.right);
  const double off = circle.head<2>().norm();
  const double radius = std::sqrt(circle.head<2>().squaredNorm() + circle[2]);
  const double limit = kOffPath / track.test.circle.radius;
  return off < limit && std::abs(radius - 1.0) < limit;
}

/// Whether another test is on its way through the same stretch.
bool CircleRecogniser::rival_in_progress(const Done& done) const {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (i == done.circle.test) continue;
    for (const Way& way : tracks_[i].ways)
      for (const Lap& lap : way.laps)
        if (lap.arc_begin_us &&
            overlap(done.arc_begin_us, done.arc_end_us, *lap.arc_begin_us, lap.arc_end_us))
          return true;
  }
  return false;
}

bool CircleRecogniser::better(const Done& a, const Done& b) const {
  const CircleToRecognise& test_a = tracks_[a.circle.test].test;
  const CircleToRecognise& test_b = tracks_[b.circle.test].test;
  if (test_a.tool.has_value() != test_b.tool.has_value()) return test_a.tool.has_value();
  const double longer = test_a.circle.arc_sweep - test_b.circle.arc_sweep;
  if (std::abs(longer) > kSameSweep) return longer > 0.0;
  const double off_a = feed_off(a.circle.feed, test_a.feed);
  const double off_b = feed_off(b.circle.feed, test_b.feed);
  if (off_a != off_b) return off_a < off_b;
  return a.circle.test < b.circle.test;
}

/// The best of several tests that differ in nothing but feed, and yet driven at another one.
bool CircleRecogniser::feed_decides_against(const Done& done) const {
  const CircleToRecognise& test = tracks_[done.circle.test].test;
  if (feed_off(done.circle.feed, test.feed) <= kFeedFits) return false;
  return std::any_of(done_.begin(), done_.end(), [&](const Done& other) {
    const CircleToRecognise& rival = tracks_[other.circle.test].test;
    return other.circle.test != done.circle.test &&
           overlap(done.arc_begin_us, done.arc_end_us, other.arc_begin_us, other.arc_end_us) &&
           rival.tool.has_value() == test.tool.has_value() &&
           std::abs(rival.circle.arc_sweep - test.circle.arc_sweep) <= kSameSweep && rival.feed != test.feed;
  });
}

/// Hands on what no rival may still take.
void CircleRecogniser::hand_on(std::vector<RecognisedCircle>& found) {
  const auto rivals = [](const Done& a, const Done& b) {
    return a.circle.test != b.circle.test &&
           (overlap(a.arc_begin_us, a.arc_end_us, b.arc_begin_us, b.arc_end_us) ||
            overlap(b.arc_begin_us, b.arc_end_us, a.arc_begin_us, a.arc_end_us));
  };
  const auto decided = [&](const Done& done) {
    return !rival_in_progress(done) && std::none_of(done_.begin(), done_.end(), [&](const Done& other) {
      return rivals(done, other) && better(other, done);
    });
  };
  for (auto best = std::find_if(done_.begin(), done_.end(), decided); best != done_.end();
       best = std::find_if(done_.begin(), done_.end(), decided)) {
    const Done chosen = *best;
    if (!feed_decides_against(chosen)) found.push_back(chosen.circle);
    done_.erase(best);
    std::erase_if(done_, [&](const Done& other) { return rivals(chosen, other); });
  }
}

}  // namespace ballbar

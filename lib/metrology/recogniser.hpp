#pragma once
/// Circles without marks: the path of the tool against the configured circles.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/recognition.hpp"
#include "core/spec.hpp"
#include "metrology/arc.hpp"

namespace ballbar {

struct CircleToRecognise {
  CircleSpec circle;
  double feed = 0.0;                    ///< [m/s] 0 = not known
  std::optional<Eigen::Matrix3d> tool;  ///< orientation in the base frame; absent = any
};

/// Follows one robot. A circle counts where the tool point went through the whole arc
///   - within kOffPath of the circle, across and along the normal, and so did the circle that fits the path:
///     a short arc of a larger circle stays near the configured one, too;
///   - one way: at most kBackwards back, with no step wider than kLargestHole and no hole in time longer than
///     kLongestJointGap;
///   - with the tool within 2 degrees of its configured orientation, where one is configured;
///   - no faster than 10 m/s, and without standing still (less than 0.1 mm in half a second).
/// It begins where the overshoot begins, or where the path came onto the circle, whichever is later; it is
/// over where the overshoot ends, or where the path left the circle, turned back, stood still or was lost.
/// Laps without a stop are one circle each; neighbours share their overshoots.
///
/// Several tests may fit one stretch of path. The one with a configured tool orientation counts first, then
/// the longest arc, then the feed nearest to the driven one, then the first of the list. Where feeds are all
/// that tells them apart, a feed more than a fifth off is none of them. A circle is held back while a rival
/// is still being driven.
///
/// Memory: at most some ten laps per test, of fixed size each.
class CircleRecogniser {
 public:
  /// `test` of what is found is an index of `tests`.
  /// @throws std::invalid_argument where a circle's normal and first axis span no plane
  explicit CircleRecogniser(std::vector<CircleToRecognise> tests);

  /// @param time_us  a sample that is not newer than the one before it is not taken
  /// @param X_BT     pose of the tool point in the base frame
  void take(std::int64_t time_us, const Eigen::Isometry3d& X_BT, std::vector<RecognisedCircle>& found);

  void end_path(std::vector<RecognisedCircle>& found);
  void reset();
  std::optional<std::int64_t> needed_since_us() const;

 private:
  /// Sums for the algebraic circle x^2 + y^2 = 2ax + 2by + c, in units of the radius about the configured
  /// centre.
  struct CircleSums {
    int count = 0;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    void add(double x, double y);
  };
  /// One passage through the arc. Angles are along the way: rising also where the circle runs clockwise.
  struct Lap {
    double arc = 0.0;  ///< [rad] where the arc begins
    std::int64_t begin_us = 0;
    std::optional<std::int64_t> arc_begin_us, arc_end_us;
    double arc_from = 0.0, arc_to = 0.0;  ///< [rad] at these two
    CircleSums path;
  };
  struct Way {
    double start = 0.0;     ///< [rad] where this one-way stretch began
    double furthest = 0.0;  ///< [rad]
    std::int64_t furthest_us = 0;
    double next_arc = 0.0;  ///< [rad] begin of the next arc that has no lap yet
    std::vector<Lap> laps;
  };
  struct Track {
    CircleToRecognise test;
    CirclePlane plane;
    bool on_circle = false;
    double angle = 0.0;       ///< [rad] without jumps
    std::array<Way, 2> ways;  ///< counter-clockwise, clockwise
  };
  struct Done {
    RecognisedCircle circle;
    std::int64_t arc_begin_us = 0, arc_end_us = 0;
  };
  struct Place {
    std::int64_t time_us = 0;
    Eigen::Vector3d point;
  };

  void follow(std::size_t index, std::int64_t time_us, const Eigen::Isometry3d& X_BT, bool resting);
  void restart(std::size_t index, int direction, double angle, std::int64_t time_us);
  void advance(std::size_t index, int direction, double angle, std::int64_t time_us);
  void end_way(std::size_t index, int direction);
  void end_track(std::size_t index);
  void finish(std::size_t index, int direction, const Lap& lap, std::int64_t end_us);
  bool driven_as_configured(const Track& track, const Lap& lap) const;
  bool rival_in_progress(const Done& done) const;
  bool better(const Done& a, const Done& b) const;
  bool feed_decides_against(const Done& done) const;
  void hand_on(std::vector<RecognisedCircle>& found);

  std::vector<Track> tracks_;
  std::vector<Done> done_;
  std::optional<std::int64_t> last_us_;
  Place anchor_;  ///< the tool has been near this place since then
};

}  // namespace ballbar

#pragma once
/// The NIST least-squares reference pairs for circles (shared/data/nist_circle2d), in the plane that they lie
/// in.

#include <Eigen/Core>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace ballbar::test {

inline constexpr int kNistSets = 30;

struct NistCircle {
  std::string name;         ///< e.g. "cir2d7.ds"
  Eigen::Matrix2Xd points;  ///< [mm]
  Eigen::Vector2d centre;   ///< [mm] reference
  double radius = 0.0;      ///< [mm] reference
};

inline std::filesystem::path shared_data() { return std::filesystem::path(BALLBAR_SHARED_DIR) / "data"; }

inline std::vector<double> numbers_in(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  std::vector<double> numbers;
  for (double number = 0.0; file >> number;) numbers.push_back(number);
  return numbers;
}

/// .ds: the count, then x y z of each point. .fit: centre x y z, normal x y z, diameter. The normal is one of
/// the axes.
inline NistCircle read_nist_circle(int number) {
  NistCircle circle;
  const std::string stem = "cir2d" + std::to_string(number);
  circle.name = stem + ".ds";
  const std::vector<double> points = numbers_in(shared_data() / "nist_circle2d" / circle.name);
  const std::vector<double> fit = numbers_in(shared_data() / "nist_circle2d" / (stem + ".fit"));
  const std::size_t count = (points.size() - 1) / 3;
  if (fit.size() != 7 || count != static_cast<std::size_t>(points[0]))
    throw std::runtime_error("odd file: " + stem);
  std::vector<std::size_t> axes;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (fit[3 + axis] == 0.0) axes.push_back(axis);
  circle.points.resize(2, static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i)
    circle.points.col(static_cast<Eigen::Index>(i)) << points[1 + 3 * i + axes.at(0)],
        points[1 + 3 * i + axes.at(1)];
  circle.centre << fit[axes.at(0)], fit[axes.at(1)];
  circle.radius = fit[6] / 2.0;
  return circle;
}

}  // namespace ballbar::test

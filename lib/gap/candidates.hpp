#pragma once
/// What a diagnosis may name: effects of the catalogue with coefficients that are free.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "gap/gap_model.hpp"

namespace ballbar {

/// One effect whose size is not known. Coefficients count in typical sizes.
struct Candidate {
  enum class Form {
    kSizes,       ///< coefficient i times typical[i] is the value of slots[i]
    kSine,        ///< two coefficients, of sine and cosine: amplitude in slots[0], phase in slots[1]
    kSquareRoot,  ///< one coefficient: the value squared, over typical squared
  };

  Effect effect;  ///< the values that are not free, and the word
  Form form = Form::kSizes;
  std::vector<std::size_t> slots;  ///< of effect.values
  std::vector<double> typical;     ///< SI, one per slot that is free
  bool positive = false;           ///< a coefficient below zero makes no sense
  bool curved = false;             ///< the pattern hangs on the size: followed again at every step
  std::string family;              ///< only one of each family and joint is named; empty: none
  double rate_sd = 0.0;            ///< cycles per turn: of a ripple whose rate was found by a scan

  int width() const { return form == Form::kSine ? 2 : static_cast<int>(typical.size()); }
  /// The effect with these coefficients.
  Effect with(const Eigen::VectorXd& coefficients) const;
  std::string label() const;  ///< "joint_lost_motion J2 backlash": for tests and traces
};

/// Every effect of the catalogue that these observations could show.
std::vector<Candidate> candidates_for(const GapModel& model, const std::vector<Observation>& observations);

/// A transmission error of a joint at so many cycles per turn.
Candidate ripple(int joint, double cycles);

/// Lost motion of one joint in every kind, from free play to friction that grows with load.
std::vector<Candidate> lost_motion_kinds(int joint);

/// The same with a second coefficient, in units of the value given, for what shapes its pattern: the friction
/// of a backlash, the time constant of thermal growth. Others come back as they are.
Candidate with_free_shape(const Candidate& candidate);

/// How far that second coefficient may go.
inline constexpr double kLeastShape = 0.3, kMostShape = 3.0;

/// How a pattern that hangs on its size is made a column.
enum class Slope {
  kTangent,  ///< its derivative at the size: for an effect that is in the model
  kChord,    ///< itself over the size: for one that competes with those that are
};

/// Columns of a candidate at a tangent: n x width [m] of the reading per typical size.
/// @param now  coefficients at which a curved pattern is taken; empty: 1
Eigen::MatrixXd columns_of(const GapModel& model, const Tangent& at, Drive& drive, const Candidate& candidate,
                           const Eigen::VectorXd& now, Slope slope);

}  // namespace ballbar

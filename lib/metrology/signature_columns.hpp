#pragma once
/// The columns of the signature fit. Used inside metrology alone.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "metrology/circle_iso.hpp"

namespace ballbar::signature {

/// Both directions, one after the other, in the frame of the fit.
struct Samples {
  double radius = 0.0;        ///< [m]
  double feed = 0.0;          ///< [m/s]
  Eigen::ArrayXd angle;       ///< [rad]
  Eigen::ArrayXd cos, sin;    ///< of the angle
  Eigen::ArrayXd way;         ///< s: +1 or -1
  Eigen::ArrayXd turns;       ///< driven since the begin of the arc
  Eigen::VectorXd deviation;  ///< [m] of the motion, the ball's offset removed
  Eigen::VectorXd weight;     ///< 0 in the dead zone of a reversal
  double noise = 0.0;         ///< [m] from sample to sample
  bool one_way = false;       ///< one direction only
};

/// A signature: its columns, per unit of its value; two or more are a vector whose length is the value.
struct Term {
  std::string name;
  Eigen::MatrixXd columns;
  double parameter = 0.0;  ///< s0 [m], 2 pi R / pitch, or order
};

/// Means of neighbours where there are more samples than the shapes need: what is found is the same, and the
/// time grows with more than their number.
/// @param enough  at most so many samples are left
CircleTrace thinned(const CircleTrace& trace, Eigen::Index enough);

/// @throws std::invalid_argument as fit_signatures
Samples samples_of(const std::vector<CircleTrace>& traces, double radius, double frame_angle);

/// "centre_offset" and all that need no search.
std::vector<Term> linear_terms(const Samples& samples);

/// "master_slave_changeover": steps at the 45 degree positions. It looks like ovals, so it is a term only
/// where it stands out.
Term changeover_term(const Samples& samples);

/// Signatures with one parameter that is searched for.
enum class Kind { kSpikeX, kSpikeY, kCyclicX, kCyclicY, kOrder };
Term searched_term(const Samples& samples, Kind kind, double parameter);

struct SearchedTerm {
  Kind kind = Kind::kOrder;
  Term term;
};

/// Finds those that are there, largest first, with their parameters. `terms` are those found so far.
std::vector<SearchedTerm> search(const Samples& samples, const std::vector<Term>& linear);

}  // namespace ballbar::signature

#pragma once
/// Set-up, zero offsets and the sizes of given effects, fitted to all observations at once (physics-gap.md 5,
/// steps 2, 5 and 7).

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "gap/candidates.hpp"
#include "gap/curve.hpp"

namespace ballbar {

/// Standard deviations before anything was measured.
struct GapPriors {
  double zero = 5e-3;       ///< [rad]; 0: the joints' zeros are held
  double ball = 3e-3;       ///< [m]
  double optics = 30e-3;    ///< [m] their zero is where a button was pressed, not where the robot is
  double bar_zero = 20e-6;  ///< [m]
  double bar_scale = 2e-3;
  double shift = 15e-3;  ///< [s]; 0: held
  double effect = 3.0;   ///< typical sizes
};

/// An effect in the model, with its sizes.
struct NamedEffect {
  Candidate candidate;
  Eigen::VectorXd coefficients;  ///< in typical sizes
};

/// Where each parameter of a fit stands in its one vector: zero offsets, set-ups, bar (zero and scale),
/// shifts, and behind this baseline the named effects in turn, then shape.
struct Layout {
  explicit Layout(const GapState& state);

  Eigen::Index zeros;    ///< one for each joint, from 0 on
  Eigen::Index set_up;   ///< from here on, 3 for each
  Eigen::Index bar;      ///< from here on, 2
  Eigen::Index shift;    ///< from here on, one for each observation
  Eigen::Index effects;  ///< from here on; so many are the baseline's

  /// Of the robot and the bar: these hold on any recording.
  std::vector<Eigen::Index> shared() const;
  /// Of one recording or one set-up.
  std::vector<Eigen::Index> own() const;
};

/// Whitened rows of all observations at one state: those of observation i begin at begin[i].
struct Linearised {
  std::vector<Tangent> tangents;
  std::vector<Eigen::Index> begin;
  Eigen::VectorXd residual;  ///< measured - predicted
  Eigen::MatrixXd baseline;  ///< per unit of each parameter of the baseline (Layout)
  Eigen::MatrixXd shape;     ///< what the named effects may be beside their formula, per standard deviation
};

/// The baseline's values at a state.
Eigen::VectorXd baseline_of(const GapState& state);

struct GapFit {
  GapState state;
  std::vector<std::shared_ptr<Loads>> loads;  ///< of each observation, where they are known
  std::vector<NamedEffect> named;
  std::optional<Curve> curve;           ///< beside them; its coefficients are the last of `shape`
  Eigen::VectorXd shape;                ///< coefficients of Linearised::shape
  Eigen::MatrixXd covariance;           ///< of baseline, coefficients of the effects in turn, shape
  double chi2 = 0.0;                    ///< of the residual after shape, without priors
  Eigen::VectorXd residual;             ///< whitened, after shape
  double rms = 0.0;                     ///< [m] of the residual after shape
  std::vector<double> observation_rms;  ///< [m]
};

class GapFitter {
 public:
  /// Both must outlive it.
  GapFitter(const GapModel& model, const std::vector<Observation>& observations)
      : model_(model), observations_(observations) {}

  const std::vector<Observation>& observations() const { return observations_; }
  const GapModel& model() const { return model_; }
  Eigen::Index rows() const;

  /// Standard deviations of the baseline's parameters, as Layout has them.
  Eigen::VectorXd baseline_sd(const GapPriors& priors) const;

  Linearised linearise(const GapFit& fit, bool with_shape) const;

  /// Whitened columns of a candidate.
  Eigen::MatrixXd columns(const Linearised& at, const Candidate& candidate, const Eigen::VectorXd& now) const;

  /// Whitened, what an effect adds to the reading, in full.
  Eigen::VectorXd contribution(const Linearised& at, const Effect& effect) const;

  /// The same of values on the places of an observation's arc [m].
  Eigen::MatrixXd whitened(std::size_t index, const Eigen::MatrixXd& values) const;

  /// Gauss-Newton, each step halved until it helps.
  /// @param start  state, effects and coefficients to begin with
  GapFit fit(GapFit start, const GapPriors& priors, bool with_shape, int steps = 8) const;

 private:
  GapState with_effects(const GapFit& fit) const;
  Eigen::VectorXd residual_of(const GapFit& fit) const;
  static Eigen::VectorXd by_shift(const AsBuilt& built, const Tangent& at, const GapState& state);
  static std::shared_ptr<Loads> loads_of(const GapFit& fit, std::size_t index) {
    return index < fit.loads.size() ? fit.loads[index] : nullptr;
  }
  void finish(const Linearised& at, GapFit& fit) const;

  const GapModel& model_;
  const std::vector<Observation>& observations_;
};

}  // namespace ballbar

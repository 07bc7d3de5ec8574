#pragma once
/// The robot with a set of effects, its set-up, and what the instrument then reads; and how that changes with
/// each.

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "gap/observation.hpp"
#include "physics/as_built.hpp"
#include "physics/drive.hpp"

namespace ballbar {

/// What is adjusted beside effects: never an effect of the robot, but for the joints' zeros.
struct GapState {
  Eigen::VectorXd zero;                 ///< [rad] zero offsets, one per joint
  std::vector<Eigen::Vector3d> set_up;  ///< [m] what each leaves open: the ball, from the programmed centre
  double bar_zero = 0.0;                ///< [m] the bar reads too long
  double bar_scale = 0.0;               ///< of its deviation
  std::vector<double>
      shift;  ///< [s] so much later than they say the bar's readings were taken; one per observation
  std::vector<Effect> effects;  ///< beside those that are configured
};

/// Everything linear about one observation at one state, on the places of its arc.
struct Tangent {
  Chain chain;                         ///< as built
  Motion motor{};                      ///< at the model's times
  std::vector<Eigen::Index> sample{};  ///< of motor: one for each place
  bool bar = true;                     ///< read by a bar: its ball may slip, its zero jump
  bool at_rest = false;  ///< the robot stands at each place: speeds only tell in which direction it came
  Conditions conditions{};
  std::shared_ptr<Loads> loads{};  ///< of this motion, or of one that is as good as the same
  Eigen::VectorXd predicted{};     ///< [m] n readings
  Eigen::MatrixXd speed{};         ///< [rad/s] n x joints
  Eigen::MatrixXd joint{}, a{}, d{}, alpha{},
      beta{};                ///< n x joints: of the reading by each (PositionColumns)
  Eigen::MatrixXd tool{};    ///< n x 3
  Eigen::MatrixXd along{};   ///< n x 3: unit vectors along which the tool point is read (Sight)
  Eigen::MatrixXd set_up{};  ///< n x 3: of the reading by what the set-up leaves open
  Eigen::VectorXd time{};    ///< [s] n

  /// Refers to this tangent, which must outlive it.
  Drive drive() const { return {motor, *loads}; }
};

/// Immutable; any number of users at once.
class GapModel {
 public:
  /// @param robot  nominal, and the effects that are known: the diagnosis looks for what is beside them
  /// @param spec   of which `robot` was made
  GapModel(const AsBuilt& robot, const RobotSpec& spec);

  const RobotModel& model() const { return robot_.model(); }
  const RobotSpec& spec() const { return spec_; }
  int joints() const { return robot_.model().joints(); }
  bool loads_known() const { return payload_known_; }  ///< the URDF has the frame that the payload hangs on

  /// Links, and the payload where it is known where it hangs.
  std::vector<Body> bodies(const Conditions& conditions) const;

  GapState start(const std::vector<Observation>& observations) const;

  /// The robot of a state: configured effects, those of the state, its zero offsets.
  AsBuilt built(const GapState& state) const;

  /// Reading [m] at the places of the arc: NaN where an effect leaves no finite angle.
  /// @param known  of the observation at a state nearby, used where it still holds; may be null
  Eigen::VectorXd predict(const AsBuilt& built, const Observation& seen, std::size_t index,
                          const GapState& state, const std::shared_ptr<Loads>& known = nullptr) const;

  /// @param known  as for predict()
  Tangent tangent(const AsBuilt& built, const Observation& seen, std::size_t index, const GapState& state,
                  const std::shared_ptr<Loads>& known = nullptr) const;

  /// What an effect adds to the reading [m], to first order in what it moves: n values. Effects with a
  /// history or a filter are followed exactly.
  Eigen::VectorXd push(const Tangent& at, Drive& drive, const Effect& effect) const;

 private:
  Sight seen_by(const AsBuilt& built, const Observation& seen, const GapState& state,
                const Eigen::MatrixXd& link_angles, const Eigen::VectorXd& time) const;
  std::shared_ptr<Loads> loads_of(const AsBuilt& built, const Observation& seen, const Motion& motor,
                                  const std::shared_ptr<Loads>& known = nullptr) const;
  Motion motor_of(const AsBuilt& built, const Observation& seen, std::size_t index,
                  const GapState& state) const;

  AsBuilt robot_;
  RobotSpec spec_;
  bool payload_known_ = false;
};

}  // namespace ballbar

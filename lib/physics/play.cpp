#include "physics/play.hpp"

#include <algorithm>
#include <cmath>

namespace ballbar {
namespace {

constexpr double kStep = 1e-3;        // [s]
constexpr double kMostSteps = 100.0;  // from one sample to the next: minutes may lie between static poses

double sign(double value) { return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0; }

/// The load at one moment.
struct Moment {
  double speed, acceleration, torque, inertia;
};

Moment between(const GapLoad& load, Eigen::Index k, double part) {
  const auto mix = [&](const Eigen::VectorXd& v) { return v(k) + part * (v(k + 1) - v(k)); };
  return {mix(load.speed), mix(load.acceleration), mix(load.torque), mix(load.inertia)};
}

class Link {
 public:
  Link(double half, double friction, const Moment& begin)
      : half_(half), friction_(friction), speed_(begin.speed) {
    flank_ = std::abs(begin.torque) > friction ? sign(begin.torque) : 0.0;
    deflection_ = -flank_ * half_;
  }

  double deflection() const { return deflection_; }

  void step(const Moment& from, const Moment& to, double h) {
    if (flank_ != 0.0 && pushed(to)) {
      speed_ = to.speed;
      return;
    }
    flank_ = 0.0;
    const double former = speed_;
    coast(from, h);
    deflection_ += h * ((former + speed_) - (from.speed + to.speed)) / 2.0;
    if (std::abs(deflection_) >= half_) {
      flank_ = -sign(deflection_);
      deflection_ = -flank_ * half_;
      speed_ = to.speed;
    }
  }

 private:
  bool pushed(const Moment& now) const {
    const double against = now.speed == 0.0 ? flank_ : sign(now.speed);
    return flank_ * (now.torque + friction_ * against) >= 0.0;
  }

  void coast(const Moment& now, double h) {
    const double load = now.torque - now.inertia * now.acceleration;  // what the link needs to stand still
    if (speed_ == 0.0 && std::abs(load) <= friction_) return;
    const double against = speed_ != 0.0 ? sign(speed_) : -sign(load);
    const double next = speed_ - h * (load + friction_ * against) / now.inertia;
    const bool turns = next * against < 0.0;
    speed_ = turns && std::abs(load) <= friction_ ? 0.0 : next;
  }

  double half_;
  double friction_;
  double speed_;
  double flank_ = 0.0;  // +1 where the motor pushes in + sense, 0 between the flanks
  double deflection_ = 0.0;
};

}  // namespace

Eigen::VectorXd play(const Eigen::Ref<const Eigen::VectorXd>& q,
                     const Eigen::Ref<const Eigen::VectorXd>& half) {
  Eigen::VectorXd deflection(q.size());
  double place = 0.0;
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const double moved = k == 0 ? 0.0 : q(k) - q(k - 1);
    if (half(k) > 0.0)
      place = std::clamp(place + moved / half(k), -1.0, 1.0);
    else if (moved != 0.0)
      place = sign(moved);
    deflection(k) = -half(k) * place;
  }
  return deflection;
}

Eigen::VectorXd gap(const GapLoad& load, double half, double friction) {
  const Eigen::Index n = load.time.size();
  Eigen::VectorXd deflection(n);
  if (n == 0) return deflection;
  Moment now{load.speed(0), load.acceleration(0), load.torque(0), load.inertia(0)};
  Link link(half, friction, now);
  deflection(0) = link.deflection();
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    const double span = load.time(k + 1) - load.time(k);
    const int steps = static_cast<int>(std::clamp(std::ceil(span / kStep - 1e-6), 1.0, kMostSteps));
    for (int i = 1; i <= steps; ++i) {
      const Moment next = between(load, k, static_cast<double>(i) / steps);
      link.step(now, next, span / steps);
      now = next;
    }
    deflection(k + 1) = link.deflection();
  }
  return deflection;
}

}  // namespace ballbar

#include "metrology/signature_columns.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/units.hpp"
#include "numerics/noise.hpp"

namespace ballbar::signature {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDeadZone = 0.1 * kRadPerDeg;  // the place of a step is not known better than the angle

/// Angle driven since motion along the axis last turned round: at 0 and 180 deg for X.
ArrayXd since_reversal(const Samples& samples, double first_reversal) {
  return (samples.way * (samples.angle - first_reversal)).unaryExpr([](double a) {
    return a - kPi * std::floor(a / kPi);
  });
}

Term one(const std::string& name, const ArrayXd& column) { return {name, column.matrix(), 0.0}; }

Term two(const std::string& name, const ArrayXd& first, const ArrayXd& second) {
  Term term{name, MatrixXd(first.size(), 2), 0.0};
  term.columns << first.matrix(), second.matrix();
  return term;
}

}  // namespace

CircleTrace thinned(const CircleTrace& trace, Index enough) {
  const Index together = (trace.angle.size() + enough - 1) / enough;
  if (together < 2 || trace.deviation.size() != trace.angle.size()) return trace;
  CircleTrace few = trace;
  const Index n = trace.angle.size() / together;
  few.angle = trace.angle.head(n * together).reshaped(together, n).colwise().mean().transpose();
  few.deviation = trace.deviation.head(n * together).reshaped(together, n).colwise().mean().transpose();
  return few;
}

Samples samples_of(const std::vector<CircleTrace>& traces, double radius, double frame_angle) {
  Samples samples;
  samples.radius = radius;
  Index n = 0;
  for (const CircleTrace& trace : traces) {
    if (std::abs(trace.direction) != 1)
      throw std::invalid_argument("signatures: a direction is not +1 or -1");
    n += trace.angle.size();
    samples.one_way = trace.direction == traces.front().direction;
  }
  samples.angle.resize(n);
  samples.way.resize(n);
  samples.turns.resize(n);
  samples.deviation.resize(n);
  samples.weight.resize(n);
  const std::vector<VectorXd> motion = motion_deviations(traces, radius);
  Index at = 0;
  double noise_squared = 0.0;
  for (std::size_t k = 0; k < traces.size(); ++k) {
    const CircleTrace& trace = traces[k];
    const Index count = trace.angle.size();
    if (count == 0) continue;
    samples.feed = trace.feed;
    samples.angle.segment(at, count) = trace.angle.array() - frame_angle;
    samples.way.segment(at, count) = trace.direction;
    samples.turns.segment(at, count) = trace.direction * (trace.angle.array() - trace.angle[0]) / kTurn;
    samples.deviation.segment(at, count) = motion[k];
    const double noise = std::max(sample_noise(motion[k]), 1e-6 * kMetresPerUm);
    noise_squared += static_cast<double>(count) * noise * noise;
    samples.weight.segment(at, count).setConstant(1.0 / (noise * noise));
    at += count;
  }
  samples.noise = n > 0 ? std::sqrt(noise_squared / static_cast<double>(n)) : 0.0;
  samples.weight *= samples.noise * samples.noise;
  samples.cos = samples.angle.cos();
  samples.sin = samples.angle.sin();
  const double dead = std::sin(kDeadZone);
  for (Index i = 0; i < n; ++i)
    if (std::min(std::abs(samples.cos[i]), std::abs(samples.sin[i])) < dead) samples.weight[i] = 0.0;
  return samples;
}

std::vector<Term> linear_terms(const Samples& samples) {
  const ArrayXd& c = samples.cos;
  const ArrayXd& s = samples.sin;
  const ArrayXd& way = samples.way;
  const ArrayXd c2 = (2.0 * samples.angle).cos();
  const ArrayXd s2 = (2.0 * samples.angle).sin();
  const ArrayXd c3 = (3.0 * samples.angle).cos();
  const ArrayXd s3 = (3.0 * samples.angle).sin();
  const double r = samples.radius;
  std::vector<Term> terms{
      two("centre_offset", c, s),
      one("radius_change", ArrayXd::Ones(c.size())),
      one("scaling_mismatch", r / 2.0 * c2),
      one("squareness", -r / 2.0 * s2),
      one("straightness_x", s3 / 4.0),
      one("straightness_y", -c3 / 4.0),
      two("three_lobe", way * c3, way * s3),
      one("backlash_x", way * s.sign() * c / 2.0),
      one("backlash_y", -way * c.sign() * s / 2.0),
      one("lateral_play_x", -way * s.abs() / 2.0),
      one("lateral_play_y", way * c.abs() / 2.0),
      one("spiral", samples.turns),
  };
  if (samples.feed > 0.0) terms.push_back(one("servo_mismatch", way * samples.feed / 2.0 * s2));
  return terms;
}

Term changeover_term(const Samples& samples) {
  return one("master_slave_changeover", (2.0 * samples.angle).cos().sign() / 2.0);
}

Term searched_term(const Samples& samples, Kind kind, double parameter) {
  const double k = parameter;
  Term term;
  switch (kind) {
    case Kind::kSpikeX:
      term = one("reversal_spike_x",
                 (-samples.radius / k * since_reversal(samples, 0.0)).exp() * samples.cos.abs());
      break;
    case Kind::kSpikeY:
      term = one("reversal_spike_y",
                 (-samples.radius / k * since_reversal(samples, kPi / 2.0)).exp() * samples.sin.abs());
      break;
    case Kind::kCyclicX:
      term = two("cyclic_x", (k * samples.cos).sin() * samples.cos, (k * samples.cos).cos() * samples.cos);
      break;
    case Kind::kCyclicY:
      term = two("cyclic_y", (k * samples.sin).sin() * samples.sin, (k * samples.sin).cos() * samples.sin);
      break;
    case Kind::kOrder: {
      // Each direction has its own phase.
      const ArrayXd there = (1.0 + samples.way) / 2.0;
      const ArrayXd cosine = (k * samples.angle).cos();
      const ArrayXd sine = (k * samples.angle).sin();
      term.name = "vibration";
      term.columns.resize(cosine.size(), samples.one_way ? 2 : 4);
      if (samples.one_way)
        term.columns << cosine.matrix(), sine.matrix();
      else
        term.columns << (there * cosine).matrix(), (there * sine).matrix(), ((1.0 - there) * cosine).matrix(),
            ((1.0 - there) * sine).matrix();
      break;
    }
  }
  term.parameter = parameter;
  return term;
}

}  // namespace ballbar::signature

#include "metrology/signatures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>
#include <tuple>

#include "core/units.hpp"

namespace ballbar {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kSignatureRadius = 0.1;
constexpr double kFeed = 0.055;
constexpr double kNoise = 0.5e-6;

double sign(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }

/// An error of a Cartesian machine, as displacements of its slides (not as radii: metrology.md 1.2 gives
/// those): where the tool is, commanded to the angle a going the way s.
struct Injected {
  std::string name;
  double value = 0.0;   ///< SI, of the signature
  double detail = 0.0;  ///< travel or pitch [m], order
  double phase = 0.0;
};

Vector2d displacement(const Injected& e, double a, int s, double turns) {
  const double x = kSignatureRadius * std::cos(a), y = kSignatureRadius * std::sin(a);
  const double vx = -s * kFeed * std::sin(a), vy = s * kFeed * std::cos(a);
  const double v = e.value;
  const Vector2d u(std::cos(a), std::sin(a));
  const auto since = [&](double reversal) {  // path since motion along an axis turned round
    double from = std::fmod(s * (a - reversal), kPi);
    if (from < 0.0) from += kPi;
    return kSignatureRadius * from;
  };
  if (e.name == "radius_change") return v * u;
  if (e.name == "scaling_mismatch") return {v / 2.0 * x, -v / 2.0 * y};
  if (e.name == "squareness") return {-v * y, 0.0};
  if (e.name == "straightness_x") return {0.0, v * (x / kSignatureRadius) * (x / kSignatureRadius)};
  if (e.name == "straightness_y") return {v * (y / kSignatureRadius) * (y / kSignatureRadius), 0.0};
  if (e.name == "servo_mismatch") return {-v * vx, 0.0};
  if (e.name == "backlash_x") return {-v / 2.0 * sign(vx), 0.0};
  if (e.name == "backlash_y") return {0.0, -v / 2.0 * sign(vy)};
  if (e.name == "lateral_play_x") return {0.0, v / 2.0 * sign(vx)};
  if (e.name == "lateral_play_y") return {v / 2.0 * sign(vy), 0.0};
  if (e.name == "reversal_spike_x") return {v * std::exp(-since(0.0) / e.detail) * sign(x), 0.0};
  if (e.name == "reversal_spike_y") return {0.0, v * std::exp(-since(kPi / 2.0) / e.detail) * sign(y)};
  if (e.name == "cyclic_x") return {v * std::sin(2.0 * kPi * x / e.detail + e.phase), 0.0};
  if (e.name == "cyclic_y") return {0.0, v * std::sin(2.0 * kPi * y / e.detail + e.phase)};
  if (e.name == "spiral") return v * turns * u;
  if (e.name == "three_lobe") return s * v * std::cos(3.0 * a + e.phase) * u;
  if (e.name == "master_slave_changeover") return v / 2.0 * sign(std::cos(2.0 * a)) * u;
  if (e.name == "vibration") return v * std::sqrt(2.0) * std::sin(e.detail * a + s * e.phase) * u;
  ADD_FAILURE() << "no such error: " << e.name;
  return Vector2d::Zero();
}

struct Driving {
  int samples = 720;
  double from_deg = 0.0, sweep_deg = 360.0;
  double frame = 0.0;  ///< [rad] the machine's X in the plane
  double noise = kNoise;
};

std::vector<CircleTrace> drive(const std::vector<Injected>& errors, const Driving& test,
                               std::mt19937& random) {
  std::normal_distribution<double> normal(0.0, 1.0);
  const Vector2d ball(20e-6, -35e-6);
  std::vector<CircleTrace> traces;
  for (const int s : {1, -1}) {
    CircleTrace trace;
    trace.direction = s;
    trace.feed = kFeed;
    trace.angle.resize(test.samples);
    trace.deviation.resize(test.samples);
    for (int i = 0; i < test.samples; ++i) {
      const double share = (i + 0.5) / test.samples;
      const double a = (test.from_deg + test.sweep_deg * (s > 0 ? share : 1.0 - share)) * kRadPerDeg;
      Vector2d at = kSignatureRadius * Vector2d(std::cos(a), std::sin(a)) + ball;
      for (const Injected& e : errors) at += displacement(e, a, s, share * test.sweep_deg / 360.0);
      trace.angle[i] = a + test.frame;
      trace.deviation[i] = at.norm() - kSignatureRadius + test.noise * normal(random);
    }
    traces.push_back(trace);
  }
  return traces;
}

const Signature* find(const SignatureFit& fit, const std::string& name) {
  const auto found = std::find_if(fit.signatures.begin(), fit.signatures.end(),
                                  [&](const Signature& s) { return s.name == name; });
  return found == fit.signatures.end() ? nullptr : &*found;
}

const std::vector<std::string> kAll{
    "radius_change",    "scaling_mismatch", "squareness", "straightness_x", "straightness_y",
    "servo_mismatch",   "backlash_x",       "backlash_y", "lateral_play_x", "lateral_play_y",
    "reversal_spike_x", "reversal_spike_y", "cyclic_x",   "cyclic_y",       "spiral",
    "three_lobe",       "vibration"};

/// Those, and what no robot has: it looks like ovals, so mixtures are without it.
const std::vector<std::string> kAlone = [] {
  std::vector<std::string> names = kAll;
  names.emplace_back("master_slave_changeover");
  return names;
}();

/// Of a size as machines and robots have it: spans from 30 to 150 um.
Injected some(const std::string& name, std::mt19937& random) {
  std::uniform_real_distribution<double> size(30e-6, 150e-6), unit(0.0, 1.0);
  const double way = unit(random) < 0.5 ? -1.0 : 1.0;
  const double span = size(random);
  Injected e{name, way * span, 0.0, 0.0};
  if (name == "scaling_mismatch" || name == "squareness") e.value = way * span / kSignatureRadius;
  if (name == "servo_mismatch") e.value = way * span / kFeed;
  if (name.starts_with("reversal_spike")) {
    e.value = 2.0 * way * span;
    e.detail = 4e-3 + 8e-3 * unit(random);
  }
  if (name == "three_lobe" || name == "vibration" || name.starts_with("cyclic")) {
    e.value = span / 2.0;
    e.phase = 6.0 * unit(random);
  }
  if (name.starts_with("cyclic")) e.detail = 8e-3 + 12e-3 * unit(random);  // orders 79 to 31
  if (name == "vibration") e.detail = std::round(20.0 + 60.0 * unit(random));
  return e;
}

/// Peak to peak of what an error does to the radius at the sampled angles.
double span_of(const Injected& e) {
  double least = 1e300, most = -1e300;
  for (const int s : {1, -1})
    for (int i = 0; i < 720; ++i) {
      const double a = (i + 0.5) / 2.0 * kRadPerDeg;
      // straightness is ranked about its own centre
      const double own = e.name == "straightness_x"   ? e.value / 4.0 * std::sin(a)
                         : e.name == "straightness_y" ? e.value / 4.0 * std::cos(a)
                                                      : 0.0;
      const double share = (s > 0 ? a : 2.0 * kPi - a) / (2.0 * kPi);
      const double radius = displacement(e, a, s, share).dot(Vector2d(std::cos(a), std::sin(a))) - own;
      least = std::min(least, radius);
      most = std::max(most, radius);
    }
  return most - least;
}

struct Judgement {
  double worst = 0.0;  ///< relative error
  double in_sd = 0.0;  ///< the largest error over its sd
  std::string which;
};

void judge(const std::vector<Injected>& errors, const SignatureFit& fit, Judgement& judgement) {
  for (const Injected& e : errors) {
    const Signature* found = find(fit, e.name);
    ASSERT_TRUE(found) << e.name << " is not told";
    ASSERT_TRUE(found->value && found->sd) << e.name;
    const double off = std::abs(*found->value - e.value) / std::abs(e.value);
    EXPECT_LT(off, 0.01) << e.name << " " << e.value << " +- " << *found->sd;
    if (off > judgement.worst) judgement.which = e.name;
    judgement.worst = std::max(judgement.worst, off);
    judgement.in_sd = std::max(judgement.in_sd, std::abs(*found->value - e.value) / *found->sd);
  }
  // Ranking: injected errors by their true spans, none that was not injected before them.
  std::map<std::string, double> spans;
  for (const Injected& e : errors) spans[e.name] = span_of(e);
  double before = 1e300;
  for (const Signature& s : fit.signatures) {
    if (!spans.contains(s.name)) {
      for (const auto& [name, span] : spans) {
        if (name != "radius_change") {
          EXPECT_LT(s.span, span) << s.name << " is not there, but ranked before " << name;
        }
      }
      continue;
    }
    EXPECT_LT(spans[s.name], before) << s.name << " ranked too low";
    before = spans[s.name];
    EXPECT_NEAR(s.share, s.span / fit.circular_error, 1e-12);
  }
}

// Some seeds here; all of them, instances named DISABLED_All, by scripts/proof signatures.
class SignaturesAlone : public testing::TestWithParam<std::tuple<std::string, unsigned>> {};

TEST_P(SignaturesAlone, AreRecoveredWithinAPercentAndRankedFirst) {
  Judgement judgement;
  const auto& [name, seeds] = GetParam();
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Injected error = some(name, random);
    const auto fit = fit_signatures(drive({error}, {}, random), kSignatureRadius, 0.0);
    ASSERT_TRUE(fit);
    judge({error}, *fit, judgement);
    // The simulator: without its one error the trace is round but for noise (and a radius is no matter of
    // roundness).
    const Signature* found = find(*fit, name);
    EXPECT_LT(found->without, name == "radius_change" ? fit->circular_error + 1e-9 : 7e-6);
  }
  std::printf("worst error %.3f %%, %.1f standard deviations\n", 100.0 * judgement.worst, judgement.in_sd);
}

std::string name_of(const testing::TestParamInfo<std::tuple<std::string, unsigned>>& p) {
  return std::get<0>(p.param);
}
INSTANTIATE_TEST_SUITE_P(Some, SignaturesAlone,
                         testing::Combine(testing::ValuesIn(kAlone), testing::Values(2u)), name_of);
INSTANTIATE_TEST_SUITE_P(DISABLED_All, SignaturesAlone,
                         testing::Combine(testing::ValuesIn(kAlone), testing::Values(20u)), name_of);

class SignaturesMixed : public testing::TestWithParam<std::tuple<unsigned, unsigned>> {};

TEST_P(SignaturesMixed, AreRecoveredWithinAPercentAndRankedRight) {
  Judgement judgement;
  const auto [first, seeds] = GetParam();
  for (unsigned seed = first; seed < first + seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::vector<std::string> names = kAll;
    std::shuffle(names.begin(), names.end(), random);
    std::vector<Injected> errors;
    for (unsigned k = 0; k < 2 + seed % 4; ++k) errors.push_back(some(names[k], random));
    Driving test;
    test.frame = seed % 3 == 0 ? 0.7 : 0.0;  // a machine that stands askew in the plane
    std::string what;
    for (const Injected& e : errors) what += e.name + " ";
    SCOPED_TRACE(what);
    const auto fit = fit_signatures(drive(errors, test, random), kSignatureRadius, test.frame);
    ASSERT_TRUE(fit);
    judge(errors, *fit, judgement);
  }
  std::printf("worst error %.3f %% (%s), %.1f standard deviations\n", 100.0 * judgement.worst,
              judgement.which.c_str(), judgement.in_sd);
}

INSTANTIATE_TEST_SUITE_P(Some, SignaturesMixed, testing::Values(std::tuple(1u, 24u)));
INSTANTIATE_TEST_SUITE_P(DISABLED_All, SignaturesMixed,
                         testing::Combine(testing::Values(1, 111, 221, 331, 441, 551),
                                          testing::Values(110u)));

class SignaturesCovered : public testing::TestWithParam<unsigned> {};

TEST_P(SignaturesCovered, LieWithinTwoStandardDeviationsAsOftenAsNormalErrorsDo) {
  int within = 0, all = 0;
  for (unsigned seed = 2001; seed < 2001 + GetParam(); ++seed) {
    std::mt19937 random(seed);
    std::vector<std::string> names = kAll;
    std::shuffle(names.begin(), names.end(), random);
    std::vector<Injected> errors;
    for (unsigned k = 0; k < 2 + seed % 4; ++k) errors.push_back(some(names[k], random));
    const auto fit = fit_signatures(drive(errors, {}, random), kSignatureRadius, 0.0);
    ASSERT_TRUE(fit);
    for (const Injected& e : errors) {
      const Signature* found = find(*fit, e.name);
      if (!found) continue;
      const bool in = std::abs(*found->value - e.value) <= 2.0 * *found->sd;
      within += in ? 1 : 0;
      ++all;
    }
  }
  const double share = static_cast<double>(within) / all;
  EXPECT_GT(share, 0.90) << within << " of " << all;
  EXPECT_LT(share, 0.98) << within << " of " << all;
  std::printf("within two standard deviations: %d of %d\n", within, all);
}

INSTANTIATE_TEST_SUITE_P(Some, SignaturesCovered, testing::Values(50));
INSTANTIATE_TEST_SUITE_P(DISABLED_All, SignaturesCovered, testing::Values(400));

TEST(Signatures, OfOneDirectionAloneAreNotToldApartWhereTheirShapesAreAlike) {
  std::mt19937 random(5);
  std::vector<CircleTrace> traces =
      drive({{"squareness", 300e-6, 0, 0}, {"backlash_x", 40e-6, 0, 0}}, {}, random);
  traces.pop_back();
  const auto fit = fit_signatures(traces, kSignatureRadius, 0.0);
  ASSERT_TRUE(fit);
  EXPECT_FALSE(find(*fit, "squareness")) << "servo mismatch has the same shape in one direction";
  EXPECT_FALSE(find(*fit, "servo_mismatch"));
  ASSERT_TRUE(find(*fit, "backlash_x")) << "its steps are like nothing else";
  EXPECT_NEAR(*find(*fit, "backlash_x")->value, 40e-6, 0.4e-6);
  ASSERT_FALSE(fit->not_told_apart.empty());
  const SignatureGroup& largest = fit->not_told_apart.front();
  EXPECT_EQ(std::count(largest.names.begin(), largest.names.end(), "squareness"), 1);
  EXPECT_EQ(std::count(largest.names.begin(), largest.names.end(), "servo_mismatch"), 1);
  EXPECT_NEAR(largest.span, 300e-6 * kSignatureRadius, 1e-6) << "the sum is known";
}

TEST(Signatures, OnPartialArcsAreEitherRightOrNotToldApartButNeverLargeAndCancelling) {
  for (const double sweep : {90.0, 120.0, 180.0, 220.0})
    for (unsigned seed = 1; seed <= 10; ++seed) {
      std::mt19937 random(seed);
      Driving test;
      test.sweep_deg = sweep;
      test.from_deg = 13.0 * seed;
      const std::vector<Injected> errors{{"backlash_x", 40e-6, 0, 0}, {"squareness", 300e-6, 0, 0}};
      const auto fit = fit_signatures(drive(errors, test, random), kSignatureRadius, 0.0);
      ASSERT_TRUE(fit);
      const std::string where = std::to_string(sweep) + " deg, seed " + std::to_string(seed);
      EXPECT_TRUE(sweep > 200.0 || !fit->not_told_apart.empty()) << where;
      for (const Signature& s : fit->signatures) {
        const auto injected =
            std::find_if(errors.begin(), errors.end(), [&](const Injected& e) { return e.name == s.name; });
        const double truth = injected == errors.end() ? 0.0 : injected->value;
        EXPECT_LT(s.span, 60e-6) << s.name << ", " << where;
        if (s.name != "vibration" && truth != 0.0) {
          EXPECT_NEAR(*s.value, truth, 0.1 * truth + 6.0 * *s.sd) << s.name << ", " << where;
        }
      }
    }
}

TEST(Signatures, OfManySamplesAreTheSame) {
  std::mt19937 random(7);
  const std::vector<Injected> errors{
      {"backlash_x", 40e-6, 0, 0}, {"squareness", 300e-6, 0, 0}, {"reversal_spike_y", 60e-6, 6e-3, 0}};
  Driving test;
  test.samples = 20'000;
  const auto fit = fit_signatures(drive(errors, test, random), kSignatureRadius, 0.0);
  ASSERT_TRUE(fit);
  for (const Injected& e : errors) {
    ASSERT_TRUE(find(*fit, e.name)) << e.name;
    EXPECT_NEAR(*find(*fit, e.name)->value / e.value, 1.0, 0.01) << e.name;
  }
}

TEST(Signatures, SayWhatIsMissing) {
  std::mt19937 random(1);
  std::vector<CircleTrace> traces = drive({}, {}, random);
  for (CircleTrace& trace : traces) trace.feed = 0.0;
  const auto fit = fit_signatures(traces, kSignatureRadius, 0.0);
  ASSERT_TRUE(fit);
  const auto named = [&](const char* name) {
    return std::any_of(fit->not_defined.begin(), fit->not_defined.end(),
                       [&](const NotDefined& each) { return each.figure == name; });
  };
  EXPECT_TRUE(named("servo_mismatch"));
  EXPECT_TRUE(named("cyclic_x")) << "noise alone has no cyclic error";
  EXPECT_FALSE(find(*fit, "reversal_spike_x"));
  EXPECT_FALSE(fit_signatures({}, kSignatureRadius, 0.0));
  traces[0].direction = 0;
  EXPECT_THROW(fit_signatures(traces, kSignatureRadius, 0.0), std::invalid_argument);
}

TEST(RadialAngle, IsThatOfTheTwoCirclesOfThePaper) {
  CircleSpec spec;
  spec.centre = {0.380, -0.320, -0.251};
  EXPECT_NEAR(to_deg(*radial_angle(spec)), -40.10, 0.005);
  spec.centre[1] = 0.320;
  EXPECT_NEAR(to_deg(*radial_angle(spec)), 40.10, 0.005);
  spec.first_axis = {0, 1, 0};
  EXPECT_NEAR(to_deg(*radial_angle(spec)), 40.10 - 90.0, 0.005);
  spec.normal = {0.380, 0.320, 0.0};
  spec.first_axis = {0, 0, 1};
  EXPECT_FALSE(radial_angle(spec)) << "the radius stands upright on the plane";
  spec.centre = {0, 0, 0.5};
  EXPECT_FALSE(radial_angle(spec)) << "a circle about the base's axis";
}

TEST(SignatureUnits, AreThoseOfTheTrade) {
  EXPECT_EQ(unit_of("squareness").unit, "um/m");
  EXPECT_EQ(unit_of("servo_mismatch").factor, 1e3);
  EXPECT_EQ(unit_of("scaling_mismatch").unit, "ppm");
  EXPECT_EQ(unit_of("backlash_x").unit, "um");
}

}  // namespace
}  // namespace ballbar

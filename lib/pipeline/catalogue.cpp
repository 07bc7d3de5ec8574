#include "pipeline/catalogue.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <complex>

#include "core/units.hpp"
#include "gap/compare.hpp"
#include "metrology/circle.hpp"
#include "metrology/signatures.hpp"

namespace ballbar {
namespace {

constexpr int kHarmonicNames = 30;
constexpr std::string_view kHarmonic = "harmonic";
constexpr std::string_view kGap = "gap_";
constexpr std::string_view kRadial = "radial_";

/// Values of one record, put in by name; what is not finite is not published.
class Values {
 public:
  explicit Values(Record& record) : record_(record) {}
  void put(const std::string& name, double value, std::optional<double> sd = {}) {
    if (!std::isfinite(value)) return;
    if (sd && !std::isfinite(*sd)) sd.reset();
    record_.values[name] = {value, sd};
  }
  void put_um(const std::string& name, double metres, std::optional<double> sd = {}) {
    put(name, to_um(metres), sd ? std::optional(to_um(*sd)) : std::nullopt);
  }
  void put_um(const std::string& name, const Estimate& metres) { put_um(name, metres.value, metres.sd); }

 private:
  Record& record_;
};

Record labels(const Run& run, const RunResult& result) {
  Record record;
  record.robot = run.robot;
  record.test = run.test;
  record.kind = run.kind == TestKind::kCircle ? "circle" : "line";
  record.series = run.series;
  record.status = result.status;
  record.angle_source = result.angle_source;
  record.source = result.source;
  record.plane = result.plane;
  record.predicted_from = result.predicted_from;
  record.direction = run.direction;
  record.repetition = run.repetition;
  record.started_us = run.started_us;
  Values values(record);
  values.put("samples", static_cast<double>(result.samples));
  values.put("lost_messages", static_cast<double>(run.lost_messages));
  values.put("feed_mm_s", to_mm(run.feed));
  values.put("payload_kg", run.payload);
  if (run.temperature) values.put("temperature_c", *run.temperature);
  return record;
}

void put_circle(Values values, const CircleResult& circle) {
  values.put_um("mean_radius_deviation_um", circle.mean_radius_deviation);
  const double eccentricity = std::hypot(circle.eccentricity_x, circle.eccentricity_y);
  values.put_um("eccentricity_um", eccentricity, circle.eccentricity_sd);
  values.put("eccentricity_deg", to_deg(std::atan2(circle.eccentricity_y, circle.eccentricity_x)));
  values.put_um("eccentricity_x_um", circle.eccentricity_x, circle.eccentricity_sd);
  values.put_um("eccentricity_y_um", circle.eccentricity_y, circle.eccentricity_sd);
  values.put_um("circular_deviation_um", circle.circular_deviation);
  values.put_um("circular_deviation_mz_um", circle.circular_deviation_mz);
  values.put_um("radial_max_um", circle.radial_max);
  values.put_um("radial_min_um", circle.radial_min);
  values.put_um("noise_um", circle.noise);
  values.put_um("residual_um", circle.residual);
  if (const std::optional<Estimate> oval = ovality(circle)) {
    const Estimate axis = *ovality_axis(circle);
    const Harmonic& h = circle.harmonics[1];
    values.put_um("ovality_um", *oval);
    values.put("ovality_axis_deg", to_deg(axis.value),
               axis.sd ? std::optional(to_deg(*axis.sd)) : std::nullopt);
    values.put_um("ovality_cos_um", h.cos, std::sqrt(h.var_cos));
    values.put_um("ovality_sin_um", h.sin, std::sqrt(h.var_sin));
  }
}

void put_figures(Values values, const CircleFigures& figures) {
  values.put("nominal_radius_mm", to_mm(figures.nominal_radius));
  values.put("start_angle_deg", to_deg(figures.start_angle));
  values.put("end_angle_deg", to_deg(figures.end_angle));
  if (figures.filter_upr) values.put("filter_upr", *figures.filter_upr);
  if (figures.calculated_feed) values.put("calculated_feed_mm_s", to_mm(*figures.calculated_feed));
  if (figures.radius_20_deviation) values.put_um("r20_deviation_um", *figures.radius_20_deviation);
  if (figures.expansion) values.put("expansion_ppm_k", to_ppm(*figures.expansion));
  values.put_um("radial_max_setup_um", figures.radial_max_setup);
  values.put_um("radial_min_setup_um", figures.radial_min_setup);
  if (figures.circular_error_mz) values.put_um("circular_error_um", *figures.circular_error_mz);
  if (figures.lsc) values.put_um("roundness_lsc_um", figures.lsc->total);
  if (figures.mzc) values.put_um("roundness_mzc_um", *figures.circular_error_mz);
  if (figures.mic) values.put_um("roundness_mic_um", figures.mic->total);
  if (figures.mcc) values.put_um("roundness_mcc_um", figures.mcc->total);
}

void put_pair(Values values, const CirclePair& pair) {
  if (pair.circular_error_b) values.put_um("circular_error_bidirectional_um", *pair.circular_error_b);
  if (pair.radial_error_d) values.put_um("mean_bidirectional_radial_error_um", *pair.radial_error_d);
  values.put_um("positional_tolerance_um", pair.positional_tolerance);
  if (!pair.hysteresis) return;
  values.put_um("hysteresis_um", *pair.hysteresis);
  values.put("hysteresis_deg", to_deg(pair.hysteresis_angle));
}

void put_harmonics(Values& values, const std::string& prefix, const std::vector<Harmonic>& harmonics) {
  for (const Harmonic& h : harmonics) {
    const std::string name = prefix + std::to_string(h.order);
    values.put_um(name + "_cos_um", h.cos, std::sqrt(h.var_cos));
    values.put_um(name + "_sin_um", h.sin, std::sqrt(h.var_sin));
    values.put_um(name + "_um", std::hypot(h.cos, h.sin));
  }
}

void put_gap(Values values, const CircleGap& gap) {
  values.put_um("gap_mean_um", gap.mean);
  values.put_um("gap_rms_um", gap.rms);
  values.put_um("gap_largest_um", gap.largest);
  values.put("gap_largest_deg", to_deg(gap.largest_angle));
  if (gap.time_shift)
    values.put("gap_time_shift_ms", to_ms(gap.time_shift->value), to_ms(gap.time_shift->sd.value_or(0.0)));
}

void put_line(Values values, const LineResult& line) {
  values.put("points", static_cast<double>(line.points.size()));
  values.put_um("straightness_mz_um", line.straightness_mz);
  values.put_um("straightness_ls_um", line.straightness_ls);
  values.put_um("straightness_ep_um", line.straightness_ep);
  values.put_um("slope_um_per_m", line.slope_ls);
  if (line.reversal_max) values.put_um("reversal_max_um", *line.reversal_max);
  if (line.reversal_mean) values.put_um("reversal_mean_um", *line.reversal_mean);
  if (!line.gap) return;
  values.put_um("gap_rms_um", line.gap->rms);
  values.put_um("gap_largest_um", line.gap->largest);
  values.put("gap_largest_mm", to_mm(line.gap->largest_position));
}

}  // namespace

const std::vector<Quantity>& catalogue() {
  static const std::vector<Quantity> all{
      {"mean_radius_deviation_um", "circle",
       "mean radius minus nominal radius, about the centre that was removed (radius change)"},
      {"eccentricity_um", "circle", "distance of the least-squares centre from the ball (centre offset)"},
      {"eccentricity_deg", "circle", "direction of the least-squares centre, from the plane's first axis"},
      {"eccentricity_x_um", "circle", "least-squares centre along the plane's first axis (centre offset X)"},
      {"eccentricity_y_um", "circle", "least-squares centre along normal x first axis (centre offset Y)"},
      {"ovality_um", "circle",
       "amplitude of harmonic 2: the longest radius minus the shortest is twice this"},
      {"ovality_axis_deg", "circle", "direction of the long axis, 0 to 180, from the plane's first axis"},
      {"ovality_cos_um", "circle", "ovality vector, first component: harmonic 2, cosine"},
      {"ovality_sin_um", "circle", "ovality vector, second component: harmonic 2, sine"},
      {"circular_deviation_um", "circle",
       "largest minus smallest radius about the least-squares centre (ISO 230-4 G; circularity)"},
      {"circular_deviation_mz_um", "circle",
       "smallest distance of two concentric circles that hold the trace (ISO 230-4 G)"},
      {"radial_max_um", "circle", "largest radius minus nominal radius, about the least-squares centre"},
      {"radial_min_um", "circle", "smallest radius minus nominal radius, about the least-squares centre"},
      {"noise_um", "circle", "standard deviation from sample to sample: noise of the instrument"},
      {"residual_um", "circle",
       "standard deviation of what all fitted harmonics leave: reversals, gear ripple, noise"},
      {"circular_error_um", "circle",
       "least radial separation of two concentric circles that hold the driven path (ISO 230-4 G)"},
      {"radial_max_setup_um", "circle", "largest radius minus nominal, about the ball (ISO 230-4 F max)"},
      {"radial_min_setup_um", "circle", "smallest radius minus nominal, about the ball (ISO 230-4 F min)"},
      {"roundness_lsc_um", "circle", "roundness about the least-squares circle (ISO 12181)"},
      {"roundness_mzc_um", "circle", "roundness about the minimum-zone circles (ISO 12181)"},
      {"roundness_mic_um", "circle", "roundness about the maximum inscribed circle (ISO 12181)"},
      {"roundness_mcc_um", "circle", "roundness about the minimum circumscribed circle (ISO 12181)"},
      {"nominal_radius_mm", "circle", "radius of the programmed circle"},
      {"start_angle_deg", "circle", "angle of the first sample that the figures by ISO are of"},
      {"end_angle_deg", "circle", "angle of the last sample that the figures by ISO are of"},
      {"filter_upr", "circle",
       "cut-off of the Gaussian filter before the figures by ISO, undulations per revolution"},
      {"circular_error_bidirectional_um", "circle",
       "least radial separation that holds the paths of both directions (ISO 230-4 G(b))"},
      {"mean_bidirectional_radial_error_um", "circle",
       "mean of both directions' least-squares radii minus nominal (ISO 230-4 D)"},
      {"hysteresis_um", "circle",
       "largest difference of both directions' radii at one angle (ISO 230-4:1996 H)"},
      {"hysteresis_deg", "circle", "angle at which both directions' radii differ most"},
      {"positional_tolerance_um", "circle",
       "width of the band about the nominal circle, the same in- and outward, that holds the paths of both "
       "directions about their common centre (positional tolerance)"},
      {"calculated_feed_mm_s", "circle",
       "mean speed over the measured arc, its length over its time, where the angles are those of the joints "
       "(calculated feed rate); 'feed_mm_s' is the programmed one"},
      {"r20_deviation_um", "circle",
       "mean radius normalised to 20 degC (R20) minus nominal radius, where a temperature was measured"},
      {"expansion_ppm_k", "circle",
       "expansion that R20 is made with: as configured, else that of steel, 11.7"},
      {"gap_rms_um", "circle",
       "measured minus predicted: root mean square about its mean, the ball where it fits best"},
      {"gap_mean_um", "circle", "measured minus predicted: mean over the circle"},
      {"gap_largest_um", "circle",
       "measured minus predicted: the largest over a degree, about the mean, with its sign"},
      {"gap_largest_deg", "circle", "angle at which measured and predicted differ most"},
      {"gap_time_shift_ms", "circle",
       "the bar's samples were taken so much later than their times say, against the joints: clocks; it is "
       "removed"},
      {"straightness_mz_um", "line",
       "smallest distance of two parallel lines that hold all points (ISO 230-1, minimum zone)"},
      {"straightness_ls_um", "line",
       "range of the deviations from the least-squares line (ISO 230-1, least-squares fit)"},
      {"straightness_ep_um", "line",
       "range of the deviations from the line through the end points (ISO 230-1, end-point fit)"},
      {"slope_um_per_m", "line", "slope of the least-squares line: the alignment of the optics"},
      {"reversal_max_um", "line", "forward minus backward, the largest by size (ISO 230-2 B)"},
      {"reversal_mean_um", "line", "forward minus backward, mean over the points"},
      {"gap_rms_um", "line",
       "measured minus predicted: root mean square, the optics aligned as it fits best"},
      {"gap_largest_um", "line", "measured minus predicted: the largest by size, with its sign"},
      {"gap_largest_mm", "line", "position at which measured and predicted differ most"},
      {"points", "line", "positions that were measured"},
      {"samples", "run", "samples in the measured arc, or readings of the line"},
      {"lost_messages", "run", "messages that the sender sent and nobody heard, while the run was open"},
      {"feed_mm_s", "run", "programmed speed of the tool point"},
      {"payload_kg", "run", "mass on the flange"},
      {"temperature_c", "run", "temperature, where it was measured"},
  };
  return all;
}

bool is_harmonic_name(std::string_view name) {
  const int orders = name.starts_with(kGap) ? kGapOrders : kHarmonicNames;
  if (name.starts_with(kGap)) name.remove_prefix(kGap.size());
  if (!name.starts_with(kHarmonic)) return false;
  name.remove_prefix(kHarmonic.size());
  int order = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), order);
  if (error != std::errc() || order < 1 || order > orders) return false;
  const std::string_view rest = name.substr(static_cast<std::size_t>(end - name.data()));
  return rest == "_um" || rest == "_cos_um" || rest == "_sin_um";
}

bool is_signature_name(std::string_view name) {
  const bool radial = name.starts_with(kRadial);
  return std::any_of(signature_names().begin(), signature_names().end(), [&](const std::string& signature) {
    return name == signature_quantity(signature, radial);
  });
}

std::string signature_quantity(const std::string& signature, bool radial) {
  std::string unit = unit_of(signature).unit;
  if (const std::size_t slash = unit.find('/'); slash != std::string::npos) unit.replace(slash, 1, "_per_");
  return std::string(radial ? kRadial : "") + "signature_" + signature + "_" + unit;
}

void put_signatures(const SignatureFit& fit, bool radial, std::map<std::string, Estimate>& values) {
  for (const Signature& signature : fit.signatures) {
    if (!signature.value) continue;
    const double factor = unit_of(signature.name).factor;
    Estimate& published = values[signature_quantity(signature.name, radial)];
    published.value = factor * *signature.value;
    if (signature.sd) published.sd = factor * *signature.sd;
  }
}

bool is_quantity(std::string_view name, std::string_view kind) {
  if (kind == "circle" && (is_harmonic_name(name) || is_signature_name(name))) return true;
  return std::any_of(catalogue().begin(), catalogue().end(), [&](const Quantity& q) {
    return q.name == name && (q.kind == kind || q.kind == "run");
  });
}

std::vector<Record> records(const Run& run, const RunResult& result) {
  std::vector<Record> all;
  const Record common = labels(run, result);
  for (const LineResult& line : result.lines) {
    Record& record = all.emplace_back(common);
    record.axis = std::string(1, line.axis);
    put_line(Values(record), line);
  }
  if (all.empty()) all.push_back(common);
  if (result.circle) put_circle(Values(all.front()), *result.circle);
  if (result.circle_figures) put_figures(Values(all.front()), *result.circle_figures);
  if (result.circle_test) put_pair(Values(all.front()), result.circle_test->figures);
  if (result.circle_gap) put_gap(Values(all.front()), *result.circle_gap);
  return all;
}

Record with_harmonics(Record record, const RunResult& result) {
  Values values(record);
  if (result.circle) put_harmonics(values, std::string(kHarmonic), result.circle->harmonics);
  if (result.circle_gap)
    put_harmonics(values, std::string(kGap) + std::string(kHarmonic), result.circle_gap->harmonics);
  if (!result.circle_test) return record;
  const CircleTest& both = *result.circle_test;
  if (both.signatures) put_signatures(*both.signatures, false, record.values);
  if (both.radial_signatures) put_signatures(*both.radial_signatures, true, record.values);
  return record;
}

}  // namespace ballbar

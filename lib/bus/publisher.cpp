#include "bus/publisher.hpp"

#include <ballbar/alarm_t.hpp>
#include <ballbar/circle_result_t.hpp>
#include <ballbar/daemon_status_t.hpp>
#include <ballbar/gap_result_t.hpp>
#include <ballbar/line_result_t.hpp>
#include <cmath>
#include <lcm/lcm-cpp.hpp>
#include <limits>

#include "bus/channels.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace ballbar {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double value(const Record& record, const char* name) {
  const auto found = record.values.find(name);
  return found == record.values.end() ? kNan : found->second.value;
}

/// Labels and conditions that both result types carry under the same names.
template <typename Message>
void fill_common(Message& m, const Run& run, const Record& record) {
  m.time_us = run.ended_us;
  m.robot = record.robot;
  m.test = record.test;
  m.series = record.series;
  m.status = record.status;
  m.direction = static_cast<std::int8_t>(record.direction);
  m.repetition = record.repetition;
  m.started_us = run.started_us;
  m.lost_messages = static_cast<std::int32_t>(run.lost_messages);
  m.feed_mm_s = to_mm(run.feed);
  m.payload_kg = run.payload;
  m.temperature_c = run.temperature.value_or(kNan);
  m.predicted_from = record.predicted_from;
  m.gap_rms_um = value(record, "gap_rms_um");
  m.gap_largest_um = value(record, "gap_largest_um");
}

circle_result_t circle_message(const Run& run, const RunResult& result, const Record& record) {
  circle_result_t m{};
  fill_common(m, run, record);
  m.angle_source = record.angle_source;
  m.source = record.source;
  m.samples = static_cast<std::int32_t>(result.samples);
  m.mean_radius_deviation_um = value(record, "mean_radius_deviation_um");
  m.eccentricity_um = value(record, "eccentricity_um");
  m.eccentricity_deg = value(record, "eccentricity_deg");
  m.ovality_um = value(record, "ovality_um");
  m.ovality_axis_deg = value(record, "ovality_axis_deg");
  m.circular_deviation_um = value(record, "circular_deviation_um");
  m.circular_deviation_mz_um = value(record, "circular_deviation_mz_um");
  m.radial_max_um = value(record, "radial_max_um");
  m.radial_min_um = value(record, "radial_min_um");
  m.noise_um = value(record, "noise_um");
  m.plane = record.plane;
  m.filter_upr = value(record, "filter_upr");
  m.start_angle_deg = value(record, "start_angle_deg");
  m.end_angle_deg = value(record, "end_angle_deg");
  m.circular_error_um = value(record, "circular_error_um");
  m.radial_max_setup_um = value(record, "radial_max_setup_um");
  m.radial_min_setup_um = value(record, "radial_min_setup_um");
  m.roundness_lsc_um = value(record, "roundness_lsc_um");
  m.roundness_mzc_um = value(record, "roundness_mzc_um");
  m.roundness_mic_um = value(record, "roundness_mic_um");
  m.roundness_mcc_um = value(record, "roundness_mcc_um");
  m.circular_error_bidirectional_um = value(record, "circular_error_bidirectional_um");
  m.mean_bidirectional_radial_error_um = value(record, "mean_bidirectional_radial_error_um");
  m.hysteresis_um = value(record, "hysteresis_um");
  m.hysteresis_deg = value(record, "hysteresis_deg");
  m.gap_mean_um = value(record, "gap_mean_um");
  m.gap_largest_deg = value(record, "gap_largest_deg");
  if (!result.circle) return m;
  for (const Harmonic& h : result.circle->harmonics) {
    m.cos_um.push_back(to_um(h.cos));
    m.sin_um.push_back(to_um(h.sin));
    m.sd_um.push_back(to_um(std::sqrt((h.var_cos + h.var_sin) / 2.0)));
  }
  m.orders = static_cast<std::int32_t>(m.cos_um.size());
  if (!result.circle_gap) return m;
  for (const Harmonic& h : result.circle_gap->harmonics) {
    m.gap_cos_um.push_back(to_um(h.cos));
    m.gap_sin_um.push_back(to_um(h.sin));
  }
  m.gap_orders = static_cast<std::int32_t>(m.gap_cos_um.size());
  return m;
}

line_result_t line_message(const Run& run, const RunResult& result, const Record& record) {
  line_result_t m{};
  fill_common(m, run, record);
  m.axis = record.axis;
  m.straightness_mz_um = value(record, "straightness_mz_um");
  m.straightness_ls_um = value(record, "straightness_ls_um");
  m.straightness_ep_um = value(record, "straightness_ep_um");
  m.reversal_max_um = value(record, "reversal_max_um");
  m.gap_largest_mm = value(record, "gap_largest_mm");
  for (const LineResult& line : result.lines) {
    if (record.axis != std::string(1, line.axis)) continue;
    for (const LinePoint& point : line.points) {
      m.position_mm.push_back(to_mm(point.position));
      m.deviation_um.push_back(to_um(point.deviation));
      m.reversal_um.push_back(point.reversal ? to_um(*point.reversal) : kNan);
      m.predicted_um.push_back(point.predicted ? to_um(*point.predicted) : kNan);
    }
  }
  m.points = static_cast<std::int32_t>(m.position_mm.size());
  return m;
}

}  // namespace

struct Publisher::Impl {
  explicit Impl(const std::string& url) : lcm(url) {}

  template <typename Message>
  void send(const char* channel, std::int64_t& seq, Message& message) {
    message.seq = ++seq;
    lcm.publish(channel, &message);  // UDP: whether it arrives is not known; the database is the record
  }

  lcm::LCM lcm;
  std::int64_t circle_seq = 0, line_seq = 0, alarm_seq = 0, status_seq = 0, gap_seq = 0;
};

Publisher::Publisher(const std::string& url) : impl_(std::make_unique<Impl>(url)) {
  if (!impl_->lcm.good())
    throw Error(Cause::kWorld, "bus " + url + ": cannot be opened for sending; is there a multicast route?");
}

Publisher::~Publisher() = default;

void Publisher::publish(const Run& run, const RunResult& result, const std::vector<Record>& records) {
  for (const Record& record : records) {
    if (run.kind == TestKind::kCircle) {
      circle_result_t m = circle_message(run, result, record);
      impl_->send("CIRCLE_RESULT", impl_->circle_seq, m);
    } else {
      line_result_t m = line_message(run, result, record);
      impl_->send("LINE_RESULT", impl_->line_seq, m);
    }
  }
}

void Publisher::publish(const AlarmStatus& alarm) {
  alarm_t m{};
  m.id = alarm.id;
  m.clean_runs = alarm.clean_runs;
  m.flapping = alarm.flapping ? 1 : 0;
  m.acknowledged_by = alarm.acknowledged.by;
  m.acknowledged_comment = alarm.acknowledged.comment;
  m.acknowledged_us = alarm.acknowledged.at_us;
  m.shelved_by = alarm.shelved.by;
  m.shelved_comment = alarm.shelved.comment;
  m.shelved_until_us = alarm.shelved.until_us;
  for (const AlarmNumber& number : alarm.numbers) {
    m.number_name.push_back(number.name);
    m.number_value.push_back(number.value);
    m.number_sd.push_back(number.sd.value_or(kNan));
    m.number_of_rule.push_back(number.of_rule ? 1 : 0);
  }
  m.numbers = static_cast<std::int32_t>(m.number_name.size());
  m.run_started_us = alarm.runs;
  m.runs = static_cast<std::int32_t>(m.run_started_us.size());
  m.time_us = alarm.judged_us;
  m.rule = alarm.key.rule;
  m.robot = alarm.key.robot;
  m.test = alarm.key.test;
  m.axis = alarm.key.axis;
  m.direction = static_cast<std::int8_t>(alarm.key.direction);
  m.state = to_string(alarm.state);
  m.severity = alarm.severity;
  m.since_us = alarm.since_us;
  m.bad_runs = alarm.bad_runs;
  m.text = alarm.text;
  impl_->send("ALARM", impl_->alarm_seq, m);
}

void Publisher::publish(const GapRecord& gap, const std::string& says) {
  gap_result_t m{};
  m.time_us = gap.ended_us;
  m.robot = gap.robot;
  m.series = gap.series;
  m.verdict = gap.verdict;
  m.noise_floor_um = to_um(gap.noise_floor);
  m.rms_before_um = to_um(gap.rms_before);
  m.rms_after_um = to_um(gap.rms_after);
  m.says = says;
  for (const GapRecord::Finding& one : gap.left_out) {
    m.effect.push_back(one.effect);
    m.kind.push_back(one.kind);
    m.joint.push_back(one.joint);
    m.level.push_back(one.level);
    m.share.push_back(one.share);
    m.evidence.push_back(one.evidence);
  }
  m.effects = static_cast<std::int32_t>(m.effect.size());
  impl_->send("GAP_RESULT", impl_->gap_seq, m);
}

void Publisher::publish(const DaemonStatus& status) {
  daemon_status_t m{};
  m.time_us = status.time_us;
  m.version = status.version;
  m.state = status.state;
  m.messages = status.messages;
  m.refused = status.refused;
  m.lost_messages = status.lost_messages;
  m.kernel_drops = status.kernel_drops;
  m.receiver_restarts = status.receiver_restarts;
  m.runs_stored = status.runs_stored;
  m.runs_ok = status.runs_ok;
  m.runs_open = status.runs_open;
  m.store_failures = status.store_failures;
  m.runs_waiting = status.runs_waiting;
  m.rules = status.rules;
  m.rules_generation = status.rules_generation;
  m.rule_errors = status.rule_errors;
  m.alarms_firing = status.alarms_firing;
  m.database = status.database;
  m.last_error = status.last_error;
  impl_->send(kPulseChannel, impl_->status_seq, m);
}

}  // namespace ballbar

#include "rules/subjects.hpp"

#include <algorithm>

#include "core/units.hpp"
#include "rules/names.hpp"

namespace ballbar {
namespace {

Record with_kind(const Record& record, const std::string& kind) {
  Record other = record;
  other.kind = kind;
  std::erase_if(other.values, [&](const auto& v) { return !is_quantity_of(v.first, kind); });
  return other;
}

Record clock_record(const std::string& kind, const std::string& robot, std::int64_t now_us) {
  Record record;
  record.kind = kind;
  record.robot = robot;
  record.status = "ok";
  record.started_us = now_us;
  return record;
}

void put_finding(Record& record, const GapRecord::Finding& finding) {
  record.words["effect"] = finding.effect;
  record.words["effect_kind"] = finding.kind;
  record.values["joint"] = {static_cast<double>(finding.joint), {}};
  record.values["level"] = {static_cast<double>(finding.level), {}};
  record.values["share"] = {finding.share, {}};
  record.values["evidence"] = {finding.evidence, {}};
}

}  // namespace

std::vector<Record> subjects_of(const Record& record) {
  std::vector<Record> found{record};
  if (record.status != "ok") return found;
  if (record.values.contains("gap_rms_um")) found.push_back(with_kind(record, "residual"));
  if (record.values.contains("positional_tolerance_um")) {
    found.push_back(with_kind(record, "test"));
    found.back().direction = 0;
  }
  return found;
}

Record silence_record(const std::string& robot, const std::string& test, std::int64_t now_us,
                      std::int64_t last_us) {
  constexpr double kUsPerHour = 3600e6;
  Record record = clock_record("silence", robot, now_us);
  record.test = test;
  // A producer's clock that runs ahead is no silence.
  record.values["hours_since_last"] = {
      static_cast<double>(std::max<std::int64_t>(0, now_us - last_us)) / kUsPerHour, {}};
  return record;
}

Record loss_record(const std::string& robot, std::int64_t now_us, const Losses& losses) {
  Record record = clock_record("loss", robot, now_us);
  const auto put = [&](const char* name, double value) { record.values[name] = {value, {}}; };
  put("runs", static_cast<double>(losses.runs));
  put("runs_failed", static_cast<double>(losses.runs_failed));
  put("lost_messages", static_cast<double>(losses.lost_messages));
  put("receiver_restarts", static_cast<double>(losses.receiver_restarts));
  put("failed_percent",
      losses.runs > 0 ? 100.0 * static_cast<double>(losses.runs_failed) / static_cast<double>(losses.runs)
                      : 0.0);
  return record;
}

Record gap_record(const GapRecord& gap) {
  Record record = clock_record("gap", gap.robot, gap.ended_us);
  record.series = gap.series;
  record.words = {{"verdict", gap.verdict}, {"effect", ""}, {"effect_kind", ""}};
  record.values["noise_floor_um"] = {to_um(gap.noise_floor), {}};
  record.values["rms_before_um"] = {to_um(gap.rms_before), {}};
  record.values["remainder_rms_um"] = {to_um(gap.rms_after), {}};
  const double share = gap.rms_before > 0.0 ? gap.rms_after / gap.rms_before : 0.0;
  record.values["explained_percent"] = {100.0 * (1.0 - share * share), {}};
  for (const GapRecord::Finding& finding : gap.left_out) {
    Record& part = record.parts.emplace_back();
    part.kind = record.kind;
    part.robot = record.robot;
    put_finding(part, finding);
  }
  if (!gap.left_out.empty()) put_finding(record, gap.left_out.front());
  return record;
}

}  // namespace ballbar

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/units.hpp"
#include "store/store.hpp"

namespace ballbar {

namespace {

void require_finite(const GapRecord& record) {
  for (const double v : {record.noise_floor, record.rms_before, record.rms_after})
    if (!std::isfinite(v)) throw std::invalid_argument("a figure of the diagnosis is not finite");
  for (const GapRecord::Finding& one : record.left_out)
    if (!std::isfinite(one.share) || !std::isfinite(one.evidence))
      throw std::invalid_argument("a finding of the diagnosis is not finite");
}

}  // namespace

void Store::save_gap(const StoredGap& gap) {
  const GapRecord& record = gap.record;
  require_finite(record);
  Transaction transaction(*db_);
  Statement(*db_, "DELETE FROM gap_result WHERE robot = ?1 AND series = ?2 AND started_us = ?3")
      .bind(record.robot, record.series, gap.started_us)
      .run();
  Statement insert(
      *db_,
      "INSERT INTO gap_result (robot, series, started_us, ended_us, verdict, noise_floor_um, "
      "rms_before_um, rms_after_um, json) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9) RETURNING id");
  insert.bind(record.robot, record.series, gap.started_us, record.ended_us, record.verdict,
              to_um(record.noise_floor), to_um(record.rms_before), to_um(record.rms_after), gap.json);
  insert.step();
  const std::int64_t id = insert.integer(0);
  insert.run();
  Statement finding(*db_,
                    "INSERT INTO gap_finding (gap_id, place, effect, kind, joint, level, share, evidence) "
                    "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)");
  int place = 0;
  for (const GapRecord::Finding& one : record.left_out)
    finding.bind(id, ++place, one.effect, one.kind, one.joint, one.level, one.share, one.evidence).run();
  transaction.commit();
}

std::vector<StoredGap> Store::gaps(const GapFilter& filter) const {
  const Snapshot snapshot(*db_);
  Statement query(*db_,
                  "SELECT id, robot, series, started_us, ended_us, verdict, noise_floor_um, rms_before_um, "
                  "rms_after_um, json FROM gap_result WHERE (?1 IS NULL OR robot = ?1) AND "
                  "(?2 IS NULL OR series = ?2) AND (?3 IS NULL OR ended_us < ?3) "
                  "ORDER BY ended_us DESC, id DESC LIMIT ?4");
  query.bind(filter.robot, filter.series, filter.before_us,
             filter.limit > 0 ? filter.limit : std::int64_t{-1});
  Statement findings(*db_,
                     "SELECT effect, kind, joint, level, share, evidence FROM gap_finding WHERE gap_id = ?1 "
                     "ORDER BY place");
  std::vector<StoredGap> found;
  while (query.step()) {
    StoredGap gap;
    gap.started_us = query.integer(3);
    gap.json = query.text(9);
    gap.record = {query.text(1),
                  query.text(2),
                  query.text(5),
                  query.integer(4),
                  kMetresPerUm * query.real(6),
                  kMetresPerUm * query.real(7),
                  kMetresPerUm * query.real(8),
                  {}};
    for (findings.bind(query.integer(0)); findings.step();)
      gap.record.left_out.push_back({findings.text(0), findings.text(1), findings.small(2), findings.small(3),
                                     findings.real(4), findings.real(5)});
    found.insert(found.begin(), std::move(gap));
  }
  return found;
}

void Store::set_model_baseline(const ModelBaseline& baseline) {
  Transaction transaction(*db_);
  Statement(*db_,
            "INSERT OR REPLACE INTO model_baseline (robot, series, ended_us, noise_floor_um, model) "
            "VALUES (?1, ?2, ?3, ?4, ?5)")
      .bind(baseline.robot, baseline.series, baseline.ended_us, to_um(baseline.noise_floor), baseline.model)
      .run();
  transaction.commit();
}

std::optional<ModelBaseline> Store::model_baseline(const std::string& robot) const {
  Statement query(
      *db_, "SELECT robot, series, ended_us, noise_floor_um, model FROM model_baseline WHERE robot = ?1");
  if (!query.bind(robot).step()) return std::nullopt;
  return ModelBaseline{query.text(0), query.text(1), query.integer(2), kMetresPerUm * query.real(3),
                       query.text(4)};
}

}  // namespace ballbar

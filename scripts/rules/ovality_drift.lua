-- Watches: whether the ovality of circles wanders from where it was when the series began. Ovality has a size and a
--          direction, an arrow; this measures how far the tip of the arrow has moved. So it also sees an ovality that keeps
--          its size but turns, which a limit on the size can not: a sign that another joint has begun to give.
-- Alarm:   when the tip is more than `limit_um` away from the mean of the first `first_runs` circles of the same series
--          (same robot, test and direction) in `hold_runs` circles in a row. It ends after more than `keep_runs` good circles
--          in a row. It says nothing until the series has its first `first_runs` circles.
--          Once the series has `baseline_runs` circles, also when what the circles since then differ from them, added up
--          (CUSUM of vectors), passes `limit_sd` standard deviations: that finds a drift by the time that it is 3 standard
--          deviations, however small those are in um.
-- Change:  `limit_um`; a good start is twenty times the scatter of repeated circles (repeated circles of a sound LR Mate lie
--          within 1 um). A larger `limit_sd` hears less. After a repair or new mastering, begin a new series, and a new
--          baseline is taken.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "ovality_drift",
  on = "circle",
  needs = { "ovality_um", "ovality_cos_um", "ovality_sin_um" },
  severity = "warning",
  hold_runs = 2,
  keep_runs = 1,

  limit_um = 20.0,
  first_runs = 3,
  limit_sd = 5.5,
  allowance_sd = 1.5,
  baseline = "series",
  baseline_runs = 100,

  gives = { "drift_um", "drift_sd", "baseline_cos_um", "baseline_sin_um" },

  when = function(result, history, rule)
    local first = history.series_first
    if #first < rule.first_runs then return false end
    local cos_um, sin_um = 0.0, 0.0
    for i = 1, rule.first_runs do
      cos_um = cos_um + first[i].ovality_cos_um / rule.first_runs
      sin_um = sin_um + first[i].ovality_sin_um / rule.first_runs
    end
    local moved_cos_um = result.ovality_cos_um - cos_um
    local moved_sin_um = result.ovality_sin_um - sin_um
    local drift_um = math.sqrt(moved_cos_um ^ 2 + moved_sin_um ^ 2)
    local drift_sd = history.vector_cusum("ovality", rule.allowance_sd) or 0
    return drift_um > rule.limit_um or drift_sd > rule.limit_sd,
      { drift_um = drift_um, drift_sd = drift_sd, baseline_cos_um = cos_um, baseline_sin_um = sin_um }
  end,

  text = "ovality of test {test} ({direction}) moved {drift_um} um from the begin of series {series}: (cos, sin) was "
    .. "({baseline_cos_um}, {baseline_sin_um}) um, is ({ovality_cos_um}, {ovality_sin_um}) um; limit {limit_um} um, "
    .. "or {limit_sd} sd added up: {drift_sd}",
}

-- Watches: the part that depends on the direction: the largest difference of both directions' radii at one angle.
--          It grows with lost motion (backlash, a loose belt) and with lag of the servos.
-- Alarm:   when what it exceeds the mean of the baseline by, beyond `allowance_sd` standard deviations, added up over the
--          runs since then (CUSUM), is above `limit_sd` in `hold_runs` runs in a row. It says nothing until the baseline has
--          its `baseline_runs` runs. It ends after more than `keep_runs` good runs in a row.
-- Change:  `limit_sd`: a larger one hears less. `baseline`: "series" begins anew with each series, "calibration" with each
--          `ballbar baseline set`.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "hysteresis_growing",
  on = "test",
  needs = { "hysteresis_um" },
  severity = "warning",
  hold_runs = 2,
  keep_runs = 1,

  limit_sd = 4.5,
  allowance_sd = 1.5,
  baseline = "calibration",
  baseline_runs = 50,

  gives = { "growth_sd", "mean_um" },

  when = function(result, history, rule)
    local growth_sd = history.cusum("hysteresis_um", rule.allowance_sd)
    if not growth_sd then return false end
    return growth_sd > rule.limit_sd, { growth_sd = growth_sd, mean_um = history.baseline("hysteresis_um") }
  end,

  text = "both directions of test {test} differ by {hysteresis_um} um, in the baseline by {mean_um} um ({growth_sd} sd added up, limit {limit_sd}): lost motion or lag has grown",
}

-- Watches: what the model of the robot does not explain: measured minus predicted, root mean square, of circles and lines.
--          The model holds the joints as they were driven, so what grows here is none of the program's doing.
-- Alarm:   when what it exceeds the mean of the baseline by, beyond `allowance_sd` standard deviations, added up over the
--          runs since then (CUSUM), is above `limit_sd` in `hold_runs` runs in a row. It says nothing until the baseline has
--          its `baseline_runs` runs. It ends after more than `keep_runs` good runs in a row.
-- Change:  `limit_sd`: a larger one hears less. `baseline`: "series" begins anew with each series, "calibration" with each
--          `ballbar baseline set`.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "residual_growing",
  on = "residual",
  needs = { "gap_rms_um" },
  severity = "warning",
  hold_runs = 2,
  keep_runs = 1,

  limit_sd = 4.5,
  allowance_sd = 1.5,
  baseline = "calibration",
  baseline_runs = 50,

  gives = { "growth_sd", "mean_um" },

  when = function(result, history, rule)
    local growth_sd = history.cusum("gap_rms_um", rule.allowance_sd)
    if not growth_sd then return false end
    return growth_sd > rule.limit_sd, { growth_sd = growth_sd, mean_um = history.baseline("gap_rms_um") }
  end,

  text = "test {test} ({direction}): {gap_rms_um} um are not explained by the model, in the baseline {mean_um} um ({growth_sd} sd added up, limit {limit_sd}): try ballbar diagnose",
}

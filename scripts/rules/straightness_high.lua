-- Watches: the straightness of lines measured with the laser interferometer: the width of the narrowest pair of parallel
--          lines that holds all readings (minimum zone).
-- Alarm:   when `hold_runs` lines in a row (same robot, test, direction and axis of deviation) are wider than `limit_um`. It
--          ends after more than `keep_runs` good lines in a row.
-- Change:  `limit_um` to what your process can bear. `where = { test = "Y", axis = "Z" }` watches one line only.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "straightness_high",
  on = "line",
  needs = { "straightness_mz_um" },
  severity = "warning",
  hold_runs = 2,
  keep_runs = 1,

  limit_um = 600.0,

  when = function(result, history, rule)
    return result.straightness_mz_um > rule.limit_um
  end,

  text = "straightness {straightness_mz_um} um of line {test} ({direction}) in {axis} is above {limit_um} um",
}

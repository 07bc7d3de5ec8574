-- Watches: the circular error by ISO 230-4 (G): how far apart two concentric circles must be to hold the whole path.
-- Alarm:   when `hold_runs` circles in a row (same robot, test and direction) are above `limit_um`. It ends after more than
--          `keep_runs` good circles in a row.
-- Change:  `limit_um` to what your process can bear; `where = { payload_kg = 3.0 }` watches circles with that load only.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "circular_error_high",
  on = "circle",
  needs = { "circular_error_um" },
  severity = "warning",
  hold_runs = 2,
  keep_runs = 1,

  limit_um = 800.0,

  when = function(result, history, rule)
    return result.circular_error_um > rule.limit_um
  end,

  text = "circular error {circular_error_um} um of test {test} ({direction}) is above {limit_um} um",
}

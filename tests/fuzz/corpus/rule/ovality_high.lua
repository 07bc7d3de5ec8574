-- Watches: the ovality of circles, that is how much longer the one diameter is than it should be. A worn or wrongly
-- mastered joint makes circles oval.
-- Alarm:   when `hold_runs` circles in a row (same robot, test and direction) are more oval than `limit_um`. It ends after
--          more than `keep_runs` good circles in a row.
-- Change:  `limit_um` to what your process can bear. `where = { robot = "..." }` gives one robot a limit of its own: copy
--          the file, and change `name` in the copy.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "ovality_high",
  on = "circle",
  needs = { "ovality_um" },
  severity = "warning",
  hold_runs = 2,
  keep_runs = 1,

  limit_um = 150.0,

  when = function(result, history, rule)
    return result.ovality_um > rule.limit_um
  end,

  text = "ovality {ovality_um} um of test {test} ({direction}) is above {limit_um} um",
}

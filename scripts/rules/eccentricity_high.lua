-- Watches: how far the ball stands from the centre of the driven circle. That is the set-up, not the robot; but a ball far off
--          makes every other figure worse, and one that moves between circles is loose.
-- Alarm:   at once when a circle's centre is more than `limit_um` off.
-- Change:  `limit_um` to what your set-up reaches.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "eccentricity_high",
  on = "circle",
  needs = { "eccentricity_um", "eccentricity_x_um", "eccentricity_y_um" },
  severity = "info",
  hold_runs = 1,
  keep_runs = 0,

  limit_um = 500.0,

  when = function(result, history, rule)
    return result.eccentricity_um > rule.limit_um
  end,

  text = "the ball of test {test} stands {eccentricity_um} um off the circle's centre, limit {limit_um} um: move it by "
    .. "({eccentricity_x_um}, {eccentricity_y_um}) um, and see that its cup is fast",
}

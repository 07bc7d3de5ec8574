-- Watches: the noise of the bar, from sample to sample. It is the instrument's, not the robot's: a dry ball cup, a loose cable,
--          a worn pivot. It sets how small a change can be seen at all.
-- Alarm:   when the noise is more than `limit_ratio` times the median of the latest 20 circles before, or more than
--          `limit_um`, in `hold_runs` circles in a row.
-- Change:  the limits.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "noise_up",
  on = "circle",
  needs = { "noise_um" },
  severity = "info",
  hold_runs = 3,
  keep_runs = 1,

  limit_um = 5.0,
  limit_ratio = 3.0,
  least_um = 0.5,   -- below it no ratio matters

  gives = { "usual_um" },

  when = function(result, history, rule)
    local usual_um = history.median("noise_um", 20)
    local is_up = usual_um and result.noise_um > rule.least_um and result.noise_um > rule.limit_ratio * usual_um
    return is_up or result.noise_um > rule.limit_um, { usual_um = usual_um or result.noise_um }
  end,

  text = "noise of the bar is {noise_um} um on {robot}, usually {usual_um} um, limit {limit_um} um: look at the ball cups",
}

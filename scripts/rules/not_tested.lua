-- Watches: for how long nothing of a robot has been measured. A robot that nobody tests raises no other alarm.
-- Alarm:   when the last good run of the robot ended more than `limit_days` ago. It ends with the next good run.
-- Change:  `limit_days`. `where = { test = "A" }` in a copy watches one test; test "" is the robot as a whole.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "not_tested",
  on = "silence",
  needs = { "hours_since_last" },
  where = { test = "" },
  severity = "info",
  hold_runs = 1,
  keep_runs = 0,

  limit_days = 30.0,

  gives = { "days" },

  when = function(result, history, rule)
    local days = result.hours_since_last / 24
    return days > rule.limit_days, { days = days }
  end,

  text = "{robot} was measured {days} days ago for the last time, limit {limit_days} days",
}

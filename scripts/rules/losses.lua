-- Watches: what of a robot was lost within a day: messages that were sent and nobody heard, and runs that gave no result.
-- Alarm:   when more than `limit_messages` messages were lost, or more than `limit_percent` of at least `least_runs` runs
--          failed. It ends when the day before is below the limits.
-- Change:  the limits.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "losses",
  on = "loss",
  needs = { "lost_messages", "runs", "failed_percent" },
  severity = "info",
  hold_runs = 1,
  keep_runs = 0,

  limit_messages = 100,
  limit_percent = 25.0,
  least_runs = 8,

  when = function(result, history, rule)
    local fails = result.runs >= rule.least_runs and result.failed_percent > rule.limit_percent
    return fails or result.lost_messages > rule.limit_messages
  end,

  text = "{robot} lost {lost_messages} messages within a day, and {failed_percent} % of {runs} runs failed: look at the network "
    .. "(ballbar list says why each run failed)",
}

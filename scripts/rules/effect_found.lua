-- Watches: each diagnosis that the service makes of a series: which physics the model leaves out, and which joint.
-- Alarm:   when a named effect explains at least `limit_share` of the mismatch, with evidence of at least `limit_evidence`
--          (ln of the odds; 5 is 150 to 1). It ends with the next diagnosis that names none.
-- Change:  the limits; `where = { robot = "..." }` watches one robot.
-- Check:   ballbar rules check; ballbar rules test

return {
  name = "effect_found",
  on = "gap",
  needs = { "remainder_rms_um" },
  severity = "warning",
  hold_runs = 1,
  keep_runs = 0,

  limit_share = 0.2,
  limit_evidence = 5.0,

  gives = { "percent" },

  when = function(result, history, rule)
    for _, finding in ipairs(result.findings) do
      if finding.share >= rule.limit_share and finding.evidence >= rule.limit_evidence then
        return true, { percent = 100 * finding.share }
      end
    end
    return false
  end,

  text = "{effect} {effect_kind} of joint {joint} explains {percent} % of the mismatch of {robot}; {remainder_rms_um} um are left",
}

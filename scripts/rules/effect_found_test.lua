-- Rows are diagnoses, one after another, each with at most one finding; see effect_found.lua.

return { rule = "effect_found.lua",
  { verdict = "nothing_missing", remainder_rms_um = 1.0, expect = "inactive" },
  { verdict = "explained", effect = "joint_lost_motion", effect_kind = "backlash", joint = 2, share = 0.83, evidence = 913.0,
    remainder_rms_um = 1.1, expect = "firing" },
  { verdict = "nothing_missing", remainder_rms_um = 1.0, expect = "resolved" },
  { verdict = "explained", effect = "joint_zero_offset", joint = 3, share = 0.1, evidence = 50.0, remainder_rms_um = 1.1,
    expect = "inactive" },   -- too small a part
  { verdict = "explained", effect = "joint_zero_offset", joint = 3, share = 0.5, evidence = 2.0, remainder_rms_um = 1.1,
    expect = "inactive" },   -- not certain
  { verdict = "unknown_effect", remainder_rms_um = 30.0, expect = "inactive" },
  { expect = "error" },      -- a missing quantity is never silence
}

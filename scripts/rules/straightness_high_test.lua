-- Rows are lines, one after another; see straightness_high.lua.

return { rule = "straightness_high.lua",
  { straightness_mz_um = 372.0, expect = "inactive" },
  { straightness_mz_um = 660.0, expect = "pending"  },   -- one bad line is not an alarm
  { straightness_mz_um = 600.0, expect = "inactive" },   -- the limit itself is good
  { straightness_mz_um = 660.0, expect = "pending"  },
  { straightness_mz_um = 660.0, axis = "Z", expect = "pending" },   -- the other axis counts for itself
  { straightness_mz_um = 600.1, expect = "firing"   },
  { straightness_mz_um = 372.0, expect = "firing"   },   -- one good line is not yet a cure
  { straightness_mz_um = 372.0, expect = "resolved" },
  { straightness_mz_um = 660.0, expect = "pending"  },
  { straightness_mz_um = 372.0, expect = "inactive" },
  { straightness_ls_um = 660.0, expect = "error"    },   -- a missing quantity is never silence
}

-- Rows are circles, one after another; see noise_up.lua.

return { rule = "noise_up.lua",
  { noise_um = 0.4, expect = "inactive" },
  { noise_um = 0.4, expect = "inactive" },
  { noise_um = 1.5, expect = "inactive" },   -- nothing to compare with: that takes three circles
  { noise_um = 0.4, expect = "inactive" },
  { noise_um = 1.5, expect = "pending"  },   -- more than three times the median
  { noise_um = 1.5, expect = "pending"  },
  { noise_um = 0.4, expect = "inactive" },
  { noise_um = 6.0, expect = "pending"  },
  { noise_um = 6.0, expect = "pending"  },
  { noise_um = 6.0, expect = "firing"   },
  { noise_um = 0.5, expect = "firing"   },
  { noise_um = 0.5, expect = "resolved" },
  { noise_um = 0.1, robot = "quiet", expect = "inactive" },
  { noise_um = 0.1, robot = "quiet", expect = "inactive" },
  { noise_um = 0.1, robot = "quiet", expect = "inactive" },
  { noise_um = 0.5, robot = "quiet", expect = "inactive" },   -- five times as much, but next to nothing
  { expect = "error" },
}

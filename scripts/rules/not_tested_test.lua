-- Rows are what the clock says, one after another; see not_tested.lua.

return { rule = "not_tested.lua",
  { test = "", hours_since_last =   1.0, expect = "inactive" },
  { test = "", hours_since_last = 720.0, expect = "inactive" },   -- 30 days: the limit itself
  { test = "", hours_since_last = 720.1, expect = "firing"   },
  { test = "", hours_since_last = 900.0, expect = "firing"   },
  { test = "", hours_since_last =   0.1, expect = "resolved" },
  { test = "A", hours_since_last = 900.0, expect = "inactive" },  -- the robot as a whole counts, not each test
  { test = "", expect = "error" },
}

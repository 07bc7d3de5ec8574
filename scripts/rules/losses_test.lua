-- Rows are a robot's last day, one after another; see losses.lua.

return { rule = "losses.lua",
  { lost_messages =   0, runs = 20, failed_percent =  0.0, expect = "inactive" },
  { lost_messages = 100, runs = 20, failed_percent = 25.0, expect = "inactive" },   -- the limits themselves
  { lost_messages = 101, runs = 20, failed_percent =  0.0, expect = "firing"   },
  { lost_messages =   0, runs = 20, failed_percent = 30.0, expect = "firing"   },
  { lost_messages =   0, runs = 20, failed_percent =  5.0, expect = "resolved" },
  { lost_messages =   0, runs =  2, failed_percent = 50.0, expect = "inactive" },   -- too few to say
  { lost_messages =   0, expect = "error" },
}

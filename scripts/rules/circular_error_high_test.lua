-- Rows are circles, one after another; see circular_error_high.lua.

return { rule = "circular_error_high.lua",
  { circular_error_um = 420.0, expect = "inactive" },
  { circular_error_um = 900.0, expect = "pending"  },   -- one bad circle is not an alarm
  { circular_error_um = 800.1, expect = "firing"   },
  { circular_error_um = 800.0, expect = "firing"   },   -- the limit itself is good; one good circle is not yet a cure
  { circular_error_um = 420.0, expect = "resolved" },
  { circular_error_um = 900.0, direction = -1, expect = "pending" },   -- the other direction counts for itself
  { circular_deviation_um = 900.0, expect = "error" },   -- a missing quantity is never silence
}

-- Rows are circles, one after another; see ovality_high.lua.

return { rule = "ovality_high.lua",
  { ovality_um =  62.0, expect = "inactive" },
  { ovality_um = 185.0, expect = "pending"  },   -- one bad circle is not an alarm
  { ovality_um =  62.0, expect = "inactive" },
  { ovality_um = 185.0, expect = "pending"  },
  { ovality_um = 150.1, expect = "firing"   },
  { ovality_um = 150.0, expect = "firing"   },   -- the limit itself is good; one good circle is not yet a cure
  { ovality_um = 209.0, expect = "firing"   },
  { ovality_um = 150.0, expect = "firing"   },
  { ovality_um = 149.0, expect = "resolved" },
  { ovality_um =  62.0, expect = "inactive" },

  { ovality_um = 185.0, direction = 1, test = "B", expect = "pending" },
  { ovality_um = 185.0, direction = -1, test = "B", expect = "pending" },   -- the other direction counts for itself
  { ovality_um = 185.0, direction = 1, test = "B", expect = "firing" },

  { ovality_um = 185.0, status = "too_few_samples", test = "C", expect = "inactive" },   -- not a result to judge
  { test = "C", expect = "error" },                                       -- a missing quantity is never silence
}

-- Rows are circles, one after another; see ovality_drift.lua. The arrow (cos, sin) is the ovality with its direction.

return { rule = "ovality_drift.lua",
  -- The first three circles of a series are its baseline: here the mean is (60, 0).
  { ovality_um = 60.0,  ovality_cos_um = 60.0,  ovality_sin_um =  0.0, expect = "inactive" },
  { ovality_um = 59.0,  ovality_cos_um = 59.0,  ovality_sin_um =  1.0, expect = "inactive" },
  { ovality_um = 61.0,  ovality_cos_um = 61.0,  ovality_sin_um = -1.0, expect = "inactive" },
  { ovality_um = 60.0,  ovality_cos_um = 60.0,  ovality_sin_um =  0.0, expect = "inactive" },

  -- Growing.
  { ovality_um = 80.0,  ovality_cos_um = 80.0,  ovality_sin_um =  0.0, expect = "inactive" },   -- 20.0 um: not above
  { ovality_um = 80.1,  ovality_cos_um = 80.1,  ovality_sin_um =  0.0, expect = "pending"  },
  { ovality_um = 82.0,  ovality_cos_um = 82.0,  ovality_sin_um =  0.0, expect = "firing"   },
  { ovality_um = 60.0,  ovality_cos_um = 60.0,  ovality_sin_um =  0.0, expect = "firing"   },
  { ovality_um = 60.0,  ovality_cos_um = 60.0,  ovality_sin_um =  0.0, expect = "resolved" },
  { ovality_um = 60.0,  ovality_cos_um = 60.0,  ovality_sin_um =  0.0, expect = "inactive" },

  -- Only turning: the size stays 60 um, a limit on it would see nothing.
  { ovality_um = 60.0,  ovality_cos_um = 57.96, ovality_sin_um = 15.53, expect = "inactive" },   -- 15 deg of phase: 15.7 um
  { ovality_um = 60.0,  ovality_cos_um = 51.96, ovality_sin_um = 30.0, expect = "pending"  },    -- 30 deg of phase: 31.1 um
  { ovality_um = 60.0,  ovality_cos_um = 51.96, ovality_sin_um = 30.0, expect = "firing"   },

  -- A slow creep never compares with the latest circles but with the first ones, so it is seen.
  { series = "creep", test = "B", ovality_um = 10.0, ovality_cos_um = 10.0, ovality_sin_um = 0.0, expect = "inactive" },
  { series = "creep", test = "B", ovality_um = 10.0, ovality_cos_um = 10.0, ovality_sin_um = 0.0, expect = "inactive" },
  { series = "creep", test = "B", ovality_um = 10.0, ovality_cos_um = 10.0, ovality_sin_um = 0.0, expect = "inactive" },
  { series = "creep", test = "B", ovality_um = 19.0, ovality_cos_um = 19.0, ovality_sin_um = 0.0, expect = "inactive" },
  { series = "creep", test = "B", ovality_um = 28.0, ovality_cos_um = 28.0, ovality_sin_um = 0.0, expect = "inactive" },
  { series = "creep", test = "B", ovality_um = 37.0, ovality_cos_um = 37.0, ovality_sin_um = 0.0, expect = "pending"  },
  { series = "creep", test = "B", ovality_um = 46.0, ovality_cos_um = 46.0, ovality_sin_um = 0.0, expect = "firing"   },

  -- A new series has a new baseline.
  { series = "mastered", test = "B", ovality_um = 90.0, ovality_cos_um = 90.0, ovality_sin_um = 0.0, expect = "firing"   },
  { series = "mastered", test = "B", ovality_um = 90.0, ovality_cos_um = 90.0, ovality_sin_um = 0.0, expect = "resolved" },
  { series = "mastered", test = "B", ovality_um = 90.0, ovality_cos_um = 90.0, ovality_sin_um = 0.0, expect = "inactive" },
  { series = "mastered", test = "B", ovality_um = 90.0, ovality_cos_um = 90.0, ovality_sin_um = 0.0, expect = "inactive" },

  { ovality_um = 60.0, expect = "error" },   -- no arrow: a missing quantity is never silence
}

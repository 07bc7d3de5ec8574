-- Rows are circles, one after another; see eccentricity_high.lua.

return { rule = "eccentricity_high.lua",
  { eccentricity_um =  40.0, eccentricity_x_um =  40.0, eccentricity_y_um = 0.0, expect = "inactive" },
  { eccentricity_um = 500.0, eccentricity_x_um = 300.0, eccentricity_y_um = 400.0, expect = "inactive" },   -- the limit itself
  { eccentricity_um = 505.0, eccentricity_x_um = 303.0, eccentricity_y_um = 404.0, expect = "firing"   },   -- at once
  { eccentricity_um =  40.0, eccentricity_x_um =  40.0, eccentricity_y_um = 0.0, expect = "resolved" },
  { eccentricity_um =  40.0, eccentricity_x_um =  40.0, eccentricity_y_um = 0.0, expect = "inactive" },
  { eccentricity_um = 505.0, expect = "error" },   -- a missing quantity is never silence
}

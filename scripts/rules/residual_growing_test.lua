-- Rows are made in a loop, one after another; see residual_growing.lua.

local rows = { rule = "residual_growing.lua" }
local function add(value_um, expect, calibrated)
  rows[#rows + 1] = { gap_rms_um = value_um, expect = expect, calibrated = calibrated }
end

-- The baseline: 50 runs about 50 um that scatter by 1 um.
for i = 1, 50 do add(50 + (i % 2 == 0 and 1 or -1), "inactive") end
for i = 1, 20 do add(50 + (i % 2 == 0 and 1 or -1), "inactive") end

-- Smaller is no alarm.
for i = 1, 5 do add(45, "inactive") end

-- Larger by 5 um: each run adds 3.9 or so, so the second passes 7.
add(55, "inactive")
add(55, "pending")
add(55, "firing")

-- A repair, and `ballbar baseline set`: 50 runs are a new baseline, where the alarm ends.
add(55, "firing", true)
add(54, "resolved")
for i = 1, 48 do add(55 + (i % 2 == 0 and 1 or -1), "inactive") end
add(55, "inactive")

rows[#rows + 1] = { expect = "error" }   -- a missing quantity is never silence
return rows

#pragma once
/// Inside physics/ only: the entries of the catalogue, each from the file of its name.

#include "physics/effect.hpp"

namespace ballbar {

EffectKind joint_zero_offset();
EffectKind link_geometry();
EffectKind tool_offset();
EffectKind joint_compliance();
EffectKind joint_lost_motion();
EffectKind path_smoothing();
EffectKind servo_lag();
EffectKind transmission_error();
EffectKind joint_eccentricity();
EffectKind thermal_growth();
EffectKind structural_vibration();
EffectKind joint_readback_lag();
EffectKind joint_readback_rounding();
EffectKind gauge_jump();
EffectKind ball_slip();
EffectKind base_drift();
EffectKind not_in_catalogue();

}  // namespace ballbar

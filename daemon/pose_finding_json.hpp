#pragma once
/// One finding of a diagnosis of static poses as JSON (design.md 7): names, parameters with units, a
/// sentence.

#include <string>

#include "daemon/json_out.hpp"
#include "gap/pose_diagnosis.hpp"

namespace ballbar {

/// As the catalogue has it. @param d  tells a rounded reading from one that lags
const char* pose_effect_name(const PoseTerm& term, const PoseDiagnosis& d);

/// The parameter that a term of geometry is; "" for others.
const char* pose_parameter_name(PoseEffect effect);

/// "joint 3"; of 0 "all joints".
std::string joint_in_words(int joint);

/// An entry of "left_out".
Json pose_finding_json(const PoseFinding& finding, const PoseDiagnosis& d);

}  // namespace ballbar

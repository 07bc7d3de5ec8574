#pragma once
/// A diagnosis of static poses as JSON (design.md 7) and as text.

#include <string>

#include "daemon/json_out.hpp"
#include "gap/pose_diagnosis.hpp"

namespace ballbar {

Json poses_json(const PoseDiagnosis& diagnosis);

/// One paragraph that a technician understands, then the tables. @param json  of poses_json()
std::string poses_text(const Json& json, const std::string& robot, const std::string& file);

}  // namespace ballbar

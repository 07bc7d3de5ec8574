#pragma once
/// A diagnosis as JSON (design.md 7), as text, and as tables of the configuration.

#include <nlohmann/json.hpp>
#include <string>

#include "gap/diagnosis.hpp"

namespace ballbar {

nlohmann::ordered_json to_json(const Diagnosis& diagnosis);

/// One paragraph for a technician, the table, the evidence.
std::string to_text(const Diagnosis& diagnosis);

/// `[[robot.effect]]` tables of what was left out: with them the model's prediction includes it.
std::string model_tables(const Diagnosis& diagnosis);

/// Corrections of the joints' zeros to type into the controller, in degrees, with their uncertainty.
/// @param convention_fanuc  the controller's J3 is the chain's J3 + J2
std::string mastering_table(const Diagnosis& diagnosis, bool convention_fanuc);

}  // namespace ballbar

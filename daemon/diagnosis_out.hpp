#pragma once
/// A diagnosis as JSON (design.md 7), as text, and as tables of the configuration.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gap/diagnosis.hpp"

namespace ballbar {

nlohmann::ordered_json to_json(const Diagnosis& diagnosis);

/// One paragraph for a technician, the table, the evidence.
std::string to_text(const Diagnosis& diagnosis);

/// What was found and a model can hold: effects of the catalogue, and all zero offsets.
std::vector<EffectSpec> found_effects(const Diagnosis& diagnosis);

/// As `[[robot.effect]]` tables.
std::string effect_tables(const std::vector<EffectSpec>& effects);

/// `[[robot.effect]]` tables of what was left out: with them the model's prediction includes it.
std::string model_tables(const Diagnosis& diagnosis);

/// Corrections of the joints' zeros to type into the controller, in degrees, with their uncertainty.
std::string mastering_table(const Diagnosis& diagnosis);

}  // namespace ballbar

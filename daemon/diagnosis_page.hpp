#pragma once
/// A diagnosis as pictures and as a page.

#include <nlohmann/json.hpp>
#include <string>

#include "gap/diagnosis.hpp"
#include "report/plot.hpp"

namespace ballbar {

/// @param picture  "map": what is left by arc and condition; "shares"; or a test: its traces before and after
/// @throws Error(kInput) where there is no such circle, or no share
PlotScript diagnosis_picture(const Diagnosis& diagnosis, const std::string& title,
                             const std::string& picture);

/// The paragraph, the table, the evidence, as part of a page.
/// @param json  as to_json() makes it
std::string diagnosis_html(const nlohmann::ordered_json& json);

/// All of it with all pictures: a page of its own.
std::string diagnosis_page(const Diagnosis& diagnosis, const std::string& title);

}  // namespace ballbar

#pragma once
/// Stored runs as JSON, by the names of the contract.

#include <nlohmann/json.hpp>
#include <string>

#include "store/store.hpp"

namespace ballbar {

using Json = nlohmann::ordered_json;

/// One run: labels, figures (null where the run does not give them), harmonics or profile.
Json to_json(const StoredRun& run);

/// Indented, with a line break at its end. Bytes that are not UTF-8 become U+FFFD: one bad label shall not
/// cost the whole export.
std::string text_of(const Json& json);

/// For a table: "-" for what is no number.
std::string figure_text(const Json& value, int decimals);

/// "(1.2, -3.4)" of an array of two.
std::string vector_text(const Json& vector, int decimals);

}  // namespace ballbar

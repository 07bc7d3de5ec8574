#pragma once
/// Stored runs as JSON, by the names of the contract.

#include <nlohmann/json.hpp>

#include "store/store.hpp"

namespace ballbar {

using Json = nlohmann::ordered_json;

/// One run: labels, figures (null where the run does not give them), harmonics or profile.
Json to_json(const StoredRun& run);

}  // namespace ballbar

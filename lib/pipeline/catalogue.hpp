#pragma once
/// Every published quantity once: its name with unit, what it means, and how it is read from a result.
/// JSON, SQL, Lua rules, lists and CSV all take their names from here.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace ballbar {

struct Quantity {
  std::string_view name;     ///< with unit, e.g. "ovality_um"
  std::string_view kind;     ///< "circle", "line" or "run" (both)
  std::string_view meaning;  ///< one sentence
};

/// All quantities, in the order in which they are shown.
const std::vector<Quantity>& catalogue();

/// True if records of `kind` ("circle" or "line") may hold `name`.
bool is_quantity(std::string_view name, std::string_view kind);

/// Harmonics are quantities too, by pattern: "harmonic<k>_cos_um", "harmonic<k>_sin_um", "harmonic<k>_um", k
/// = 1..30, kind "circle"; and with "gap_" before them those of measured minus predicted, k = 1..10.
bool is_harmonic_name(std::string_view name);

/// So are the error signatures of both directions (metrology/signatures.hpp), kind "circle":
/// "signature_<name>_<unit>" in the plane's frame, "radial_signature_<name>_<unit>" in the radial one.
bool is_signature_name(std::string_view name);

/// "signature_backlash_x_um".
std::string signature_quantity(const std::string& signature, bool radial);

/// The result in published names and units: one Record for a circle, one per axis for a line. A run that gave
/// no figures still gives one Record, with its labels and conditions.
std::vector<Record> records(const Run& run, const RunResult& result);

/// A circle's record with its harmonics, measured and of the gap, and signatures as quantities, as rules see
/// it.
Record with_harmonics(Record record, const RunResult& result);

/// Adds those that are told apart.
void put_signatures(const SignatureFit& fit, bool radial, std::map<std::string, Estimate>& values);

}  // namespace ballbar

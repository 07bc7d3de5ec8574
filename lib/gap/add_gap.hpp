#pragma once
/// The prediction of a run, and the gap, into its result.

#include "core/result.hpp"
#include "core/run.hpp"
#include "core/spec.hpp"
#include "physics/as_built.hpp"

namespace ballbar {

/// Predicts the run from its joints where they are there, else from the commanded path, and compares. Nothing
/// is filled in where the result has no figures, or where the model cannot drive the test. A virtual bar,
/// made of the joints themselves, is compared with the command.
/// @param result  analysed; predicted_from, predicted, circle_gap and the lines' gap are filled in
void add_gap(const Run& run, const TestSpec& test, const AsBuilt& robot, RunResult& result);

}  // namespace ballbar

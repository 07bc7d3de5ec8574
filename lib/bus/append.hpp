#pragma once
/// Samples into the columns of a Run.

#include "core/run.hpp"
#include "core/samples.hpp"

namespace ballbar {

/// Samples before the run's begin, or not after those that it holds, are left out.
void append(Run& run, const BallbarBlock& block);
void append(Run& run, const InterferometerBlock& block);

/// @return false where the number of joints is not that of the samples before
bool append(Run& run, const JointSample& sample);

/// Takes away what lies behind ended_us: blocks that were sent before the end may hold samples behind it.
void cut_to_end(Run& run);

}  // namespace ballbar

#pragma once
/// The extended baseline: the whole model of a commissioned robot, against which later diagnoses are made.

#include <string>

#include "core/spec.hpp"
#include "gap/diagnosis.hpp"
#include "store/store.hpp"

namespace ballbar {

/// What is configured and what was found beside it, as far as a model can hold it.
ModelBaseline model_baseline_of(const RobotSpec& robot, const Diagnosis& diagnosis, const std::string& series,
                                std::int64_t ended_us);

/// The robot with the baseline's effects instead of the configured ones: what a diagnosis then finds has
/// changed since. @throws Error(kWorld) where the stored model cannot be read
RobotSpec with_baseline(RobotSpec robot, const ModelBaseline& baseline);

}  // namespace ballbar

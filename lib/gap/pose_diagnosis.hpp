#pragma once
/// The gap of static poses: which physics is left out of the model, how large, and the proof on poses that
/// were not fitted. Source: physics-gap.md 5 and 12.

#include <optional>
#include <string>
#include <vector>

#include "gap/pose_search.hpp"
#include "gap/poses.hpp"

namespace ballbar {

enum class PoseHoldOut {
  kDefault,    ///< the column held_out or series held out as a whole; without any kBlocks and kRandom
  kBlocks,     ///< contiguous in the order of measurement
  kRandom,     ///< with a fixed seed
  kEachPlace,  ///< each joint pose in turn
};

struct PoseDiagnosisOptions {
  PoseHoldOut hold_out = PoseHoldOut::kDefault;
  PoseSearchOptions search;
  unsigned seed = 1;     ///< of kRandom
  int most_rows = 2500;  ///< that are fitted, taken evenly from those that may be
};

/// One model more in the row from the configured one to the one with everything that was found.
struct PoseStep {
  std::string
      model;  ///< "configured", "zero offsets", "geometry", "compliance", "all"; each holds the ones before
  double fitted = 0.0;                           ///< [m] rms of the fitted rows
  double held_out = 0.0, held_out_median = 0.0;  ///< [m] of those that were not
};

/// A prediction of rows that were not fitted, everything searched and fitted anew without them.
struct PoseProof {
  std::string how;                ///< "column", "series", "blocks", "random", "each pose"
  int parts = 1;                  ///< how many times a part was left out
  int rows = 0, fitted_rows = 0;  ///< predicted in all; fitted in one of the parts
  std::vector<PoseStep> steps;
  PoseCoverage coverage;  ///< of all parts together

  const PoseStep& before() const { return steps.front(); }
  const PoseStep& after() const { return steps.back(); }
};

/// An effect with figures: values of its term with standard deviations.
struct PoseFinding {
  PoseTerm term;
  std::vector<double> values, sd;  ///< SI
  int level = 3;                   ///< 1 zero offsets, 2 geometry, 3 everything else
  double evidence = 0.0;           ///< ln of odds
  double contribution = 0.0;       ///< [m] rms of what nothing else explains
  double share = 0.0;              ///< of what all findings explain
  std::vector<PoseTerm> cannot_be_told_from;
};

enum class PoseVerdict { kNothingMissing, kExplained, kPartlyExplained, kUnknownEffect };

struct PoseDiagnosis {
  PoseVerdict verdict = PoseVerdict::kNothingMissing;
  double noise_floor = 0.0;         ///< [m] rms of a point (3-D) or length
  bool noise_from_repeats = false;  ///< else it is what the fit leaves
  int fitted_rows = 0;
  double before = 0.0, after = 0.0;   ///< [m] rms of the fitted rows
  std::vector<PoseFinding> left_out;  ///< the largest first
  std::vector<PoseProof> held_out;
  PoseState state;                 ///< set-ups and every term of the final model
  std::vector<PoseTerm> absorbed;  ///< geometry that base frame and tool point make up for: never named
  bool one_frame = false;          ///< several series share one base frame
  std::vector<std::string> frames, tools, not_applied;
  bool lengths = false;
  bool remainder = false;        ///< more is left than the repeats explain, or structure in it
  PoseTerm remainder_structure;  ///< the largest curve, where there is one
  bool structured = false;
  double reading_step = 0.0;          ///< [rad] all readings are multiples of it; 0: of none
  double command_on_move = 0.0;       ///< part of the last move by which the readings lack the command
  bool command_follows_move = false;  ///< that is what the difference of command and reading looks like
};

/// @throws Error(kInput) as prepare_poses
PoseDiagnosis diagnose_poses(const PoseRows& rows, const Chain& chain, const PoseDiagnosisOptions& options);

}  // namespace ballbar

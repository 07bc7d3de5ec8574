#include "store/labels.hpp"

#include <array>
#include <utility>

namespace ballbar {

namespace {

constexpr std::array<std::pair<RunEnd, const char*>, 10> kEnds = {
    {{RunEnd::kMark, "mark"},
     {RunEnd::kAborted, "aborted"},
     {RunEnd::kSilence, "silence"},
     {RunEnd::kNextBegin, "next_begin"},
     {RunEnd::kProducerRestart, "producer_restart"},
     {RunEnd::kInterrupted, "interrupted"},
     {RunEnd::kTooLong, "too_long"},
     {RunEnd::kMarksLost, "marks_lost"},
     {RunEnd::kNoBegin, "no_begin"},
     {RunEnd::kGeometry, "geometry"}}};

}  // namespace

const char* to_string(TestKind kind) { return kind == TestKind::kLine ? "line" : "circle"; }

const char* to_string(RunEnd end) {
  for (const auto& [value, word] : kEnds)
    if (value == end) return word;
  return "mark";
}

TestKind test_kind_from(std::string_view word) {
  return word == "line" ? TestKind::kLine : TestKind::kCircle;
}

RunEnd run_end_from(std::string_view word) {
  for (const auto& [value, name] : kEnds)
    if (word == name) return value;
  return RunEnd::kMark;
}

}  // namespace ballbar

#pragma once
/// Words of the database for what the core says by enumerators.

#include <string>
#include <string_view>

#include "core/run.hpp"

namespace ballbar {

/// "circle" or "line".
const char* to_string(TestKind kind);
/// "mark", "aborted", "silence", "next_begin", "producer_restart", "interrupted" or "too_long".
const char* to_string(RunEnd end);

TestKind test_kind_from(std::string_view word);
RunEnd run_end_from(std::string_view word);

}  // namespace ballbar

#pragma once
/// The small words of a gnuplot script: quoted text and numbers.

#include <string>
#include <string_view>

namespace ballbar {

/// Any text as a gnuplot string in single quotes that cannot end early: control characters become spaces,
/// bytes that are not UTF-8 become U+FFFD, quotes become U+2019, and what is longer than 160 characters is
/// cut with an ellipsis.
std::string gnuplot_quoted(std::string_view text);

/// Fixed-point with at most `decimals` digits after the point, trailing zeros removed; never follows the
/// locale.
std::string plain_number(double value, int decimals);

}  // namespace ballbar

#pragma once
/// Alarm texts with {placeholders}.

#include <functional>
#include <string>
#include <vector>

namespace ballbar {

/// The names between braces, in their order.
/// @throws std::invalid_argument where a brace has no partner or encloses something that is no name
std::vector<std::string> placeholders(const std::string& text);

/// The text with each {name} replaced by value_of(name). One line: control characters become blanks.
std::string fill(const std::string& text, const std::function<std::string(const std::string&)>& value_of);

/// Line `line` (from 1) of a source without its indent, 200 characters at most; empty where there is none.
std::string text_of_line(const std::string& source, int line);

/// A number as a person would write it into a sentence: 150, 184.3, 7.25, 0.0312.
std::string short_number(double value);

}  // namespace ballbar

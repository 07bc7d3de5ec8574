#pragma once
/// What the readers of files say of a text, and ask of it.

#include <string>
#include <string_view>

#include "core/error.hpp"

namespace ballbar {

/// The file cannot be taken. @param why  a clause that follows the file's name
inline Error refused(const std::string& why) { return {Cause::kInput, why}; }

/// In quotes, its first 40 characters.
std::string quoted(std::string_view text);

/// Without a byte order mark.
/// @throws Error(kInput) for UTF-16 and binary data
std::string_view checked_text(std::string_view bytes);

}  // namespace ballbar

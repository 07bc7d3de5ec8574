#pragma once
/// Characters of texts that come from outside.

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace ballbar {

struct Character {
  std::size_t bytes = 0;  ///< 0: not UTF-8
  std::uint32_t code = 0;
};

/// The character at the front of `text`, which is not empty, by the table of RFC 3629: no overlong forms, no
/// surrogates.
Character first_character(std::string_view text);

/// Control characters, line and paragraph separators, and what XML 1.0 does not allow.
bool is_unprintable(std::uint32_t code);

/// How many characters `text` has.
std::size_t characters_of(std::string_view text);

}  // namespace ballbar

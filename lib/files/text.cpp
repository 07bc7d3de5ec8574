#include "files/text.hpp"

namespace ballbar {

std::string quoted(std::string_view text) { return "'" + std::string(text.substr(0, 40)) + "'"; }

std::string_view checked_text(std::string_view bytes) {
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.remove_prefix(3);
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF"))
    throw refused("is UTF-16 text; save it as UTF-8");
  if (bytes.find('\0') != std::string_view::npos) throw refused("holds binary data, is no CSV");
  return bytes;
}

}  // namespace ballbar

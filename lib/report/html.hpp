#pragma once
/// A page that needs nothing but itself: no script, no style sheet, font or picture from elsewhere.
///
/// Every text that is handed in is plain text and is escaped here; only `body` and what the functions return
/// is HTML.

#include <string>
#include <string_view>
#include <vector>

namespace ballbar {

/// Plain text as the content of an element or of a quoted attribute. Bytes that are not UTF-8 become U+FFFD,
/// control characters spaces.
std::string html_text(std::string_view text);

/// <tag>text</tag>. @param tag  a word of ours, e.g. "h2"
std::string html_element(std::string_view tag, std::string_view text);

struct HtmlTable {
  std::vector<std::string> heading{};
  std::vector<std::vector<std::string>> rows{};  ///< each as long as the heading
  std::size_t left = 1;  ///< so many columns are words, to the left; the others are figures, to the right
  bool last_is_words = false;  ///< the last column too
};

/// @throws std::invalid_argument where a row is not as long as the heading
std::string html_table(const HtmlTable& table);

/// A picture of gnuplot with a caption. Ids in it get a prefix, so that pictures of one page do not mix.
/// @param svg     as svg_of() gives it
/// @param prefix  a word of ours, another one for each picture of a page
std::string html_figure(std::string_view svg, std::string_view prefix, std::string_view caption);

/// The whole page. It reads on a phone, and prints on A4 without torn tables and pictures. Nothing in it can
/// load or run anything: a policy in its head forbids it.
std::string html_page(std::string_view title, std::string_view body);

}  // namespace ballbar

#include "report/html.hpp"

#include <array>
#include <stdexcept>
#include <utility>

#include "report/utf8.hpp"

namespace ballbar {
namespace {

constexpr std::string_view kStyle = R"(
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #1a1a1a; background: #fff;
  max-width: 70rem; margin: 0 auto; padding: 1rem; overflow-wrap: anywhere; }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.25rem; margin: 2rem 0 .5rem; border-bottom: 2px solid #0072B2; }
h3 { font-size: 1.05rem; margin: 1.2rem 0 .3rem; }
p { margin: .4rem 0; }
.wide { overflow-x: auto; margin: .5rem 0; }
table { border-collapse: collapse; font-size: .85rem; overflow-wrap: normal; }
th, td { padding: .2rem .5rem; border-bottom: 1px solid #d0d0d0; vertical-align: top; text-align: left; }
th { border-bottom: 2px solid #404040; vertical-align: bottom; }
td:first-child { white-space: nowrap; }
.n { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
th.n { white-space: normal; }
.w { min-width: 12rem; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr)); gap: 1rem;
  align-items: start; }
figure { margin: 0; border: 1px solid #d0d0d0; padding: .5rem; }
figure svg { display: block; width: 100%; height: auto; }
figcaption { font-size: .9rem; color: #404040; }
@page { size: A4; margin: 14mm; }
@media print {
  body { font-size: 10pt; max-width: none; padding: 0; }
  .wide { overflow: visible; }
  table { font-size: 8pt; }
  th, td { padding: .1rem .35rem; }
  .w { min-width: 6rem; }
  thead { display: table-header-group; }
  tr, figure { break-inside: avoid; }
  h1, h2, h3, h2 + p, h3 + p { break-after: avoid; }
  .pictures { display: block; }
  figure { margin: 0 auto 6mm; max-width: 120mm; }
}
)";

void replace_after(std::string& tag, std::string_view what, std::string_view prefix) {
  for (std::size_t at = tag.find(what); at != std::string::npos; at = tag.find(what, at + what.size()))
    tag.insert(at + what.size(), prefix);
}

/// The <svg> element alone, its ids and the references to them with a prefix. Only tags are changed: texts
/// hold no bare '<'.
std::string inline_svg(std::string_view svg, std::string_view prefix) {
  const std::size_t begin = svg.find("<svg");
  if (begin == std::string_view::npos) throw std::invalid_argument("html_figure: no SVG");
  svg.remove_prefix(begin);
  std::string text;
  while (!svg.empty()) {
    const std::size_t open = svg.find('<');
    text += svg.substr(0, open);
    if (open == std::string_view::npos) break;
    const std::size_t end = svg.find('>', open);
    if (end == std::string_view::npos) throw std::invalid_argument("html_figure: an SVG that breaks off");
    std::string tag(svg.substr(open, end - open + 1));
    svg.remove_prefix(end + 1);
    if (tag == "<title>" || tag == "<desc>") {  // "Gnuplot" would be shown beside the pointer
      const std::string closing = "</" + tag.substr(1);
      const std::size_t close = svg.find(closing);
      if (close != std::string_view::npos) svg.remove_prefix(close + closing.size());
      continue;
    }
    constexpr std::array<std::string_view, 5> references{" id='", " id=\"", "href='#", "href=\"#", "url(#"};
    for (const std::string_view reference : references) replace_after(tag, reference, prefix);
    text += tag;
  }
  return text;
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string escaped;
  while (!text.empty()) {
    const Character c = first_character(text);
    if (c.bytes == 0)
      escaped += "\uFFFD";
    else if (c.code == '&')
      escaped += "&amp;";
    else if (c.code == '<')
      escaped += "&lt;";
    else if (c.code == '>')
      escaped += "&gt;";
    else if (c.code == '"')
      escaped += "&quot;";
    else if (c.code == '\'')
      escaped += "&#39;";
    else if (is_unprintable(c.code))
      escaped += ' ';
    else
      escaped += text.substr(0, c.bytes);
    text.remove_prefix(c.bytes == 0 ? 1 : c.bytes);
  }
  return escaped;
}

std::string html_element(std::string_view tag, std::string_view text) {
  const std::string name(tag);
  return "<" + name + ">" + html_text(text) + "</" + name + ">\n";
}

std::string html_table(const HtmlTable& table) {
  const std::size_t columns = table.heading.size();
  const auto row = [&](const std::vector<std::string>& cells, const std::string& tag) {
    if (cells.size() != columns) throw std::invalid_argument("html_table: a row as long as the heading");
    std::string text = "<tr>";
    for (std::size_t k = 0; k < columns; ++k) {
      const bool last_words = table.last_is_words && k + 1 == columns;
      const std::string kind = k < table.left ? "" : last_words ? " class=\"w\"" : " class=\"n\"";
      text.append("<").append(tag).append(kind).append(">").append(html_text(cells[k]));
      text.append("</").append(tag).append(">");
    }
    return text + "</tr>\n";
  };
  std::string text =
      "<div class=\"wide\"><table>\n<thead>" + row(table.heading, "th") + "</thead>\n<tbody>\n";
  for (const auto& cells : table.rows) text += row(cells, "td");
  return text + "</tbody></table></div>\n";
}

std::string html_figure(std::string_view svg, std::string_view prefix, std::string_view caption) {
  return "<figure>\n" + inline_svg(svg, std::string(prefix) + "-") + html_element("figcaption", caption) +
         "</figure>\n";
}

std::string html_page(std::string_view title, std::string_view body) {
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  page +=
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
      "'unsafe-inline'; img-src data:\">\n";
  page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  page += "<link rel=\"icon\" href=\"data:,\">\n";  // else a browser asks the server for one
  page += html_element("title", title);
  page += "<style>" + std::string(kStyle) + "</style>\n</head>\n<body>\n";
  page += body;
  return page + "</body>\n</html>\n";
}

}  // namespace ballbar

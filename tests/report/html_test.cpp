#include "report/html.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace ballbar {
namespace {

bool holds(const std::string& text, const std::string& word) { return text.find(word) != std::string::npos; }

TEST(HtmlText, NeverOpensATagAnEntityOrAnAttribute) {
  struct Row {
    std::string text, escaped;
  };
  for (const Row& row : {
           Row{"lrmate-1", "lrmate-1"},
           Row{"", ""},
           Row{"<script>alert(1)</script>", "&lt;script&gt;alert(1)&lt;/script&gt;"},
           Row{"a&b &lt;", "a&amp;b &amp;lt;"},
           Row{"\" onload='x", "&quot; onload=&#39;x"},
           Row{"a\nb\tc", "a b c"},
           Row{std::string("a\0b", 3), "a b"},
           Row{"µm ±", "µm ±"},
           Row{"\xFF\xC0\xAF", "\uFFFD\uFFFD\uFFFD"},
       })
    EXPECT_EQ(html_text(row.text), row.escaped);
}

TEST(HtmlTable, PutsWordsLeftAndFiguresRight) {
  const std::string table = html_table(
      {.heading = {"figure", "µm", "what it is"}, .rows = {{"a<b", "1.50", "x & y"}}, .last_is_words = true});
  EXPECT_TRUE(holds(table, "<td>a&lt;b</td><td class=\"n\">1.50</td><td class=\"w\">x &amp; y</td>"))
      << table;
  EXPECT_THROW(html_table({.heading = {"a", "b"}, .rows = {{"1"}}}), std::invalid_argument);
}

TEST(HtmlFigure, KeepsThePicturesOfAPageApart) {
  const std::string svg =
      "<?xml version=\"1.0\"?>\n<!DOCTYPE svg>\n<svg viewBox=\"0 0 1 1\"><title>Gnuplot</title><desc>by "
      "gnuplot</desc>"
      "<path id='gpPt0'/><use xlink:href='#gpPt0' id='gpPt1'/><g id=\"plot_1\" fill='url(#gpPt0)'/>"
      "<text> id='stays' href='#stays</text></svg>\n";
  const std::string figure = html_figure(svg, "p7", "a <caption>");
  for (const char* word :
       {"id='p7-gpPt0'", "href='#p7-gpPt0' id='p7-gpPt1'", "id=\"p7-plot_1\"", "url(#p7-gpPt0)",
        "> id='stays' href='#stays<", "<figcaption>a &lt;caption&gt;</figcaption>"})
    EXPECT_TRUE(holds(figure, word)) << word << " in\n" << figure;
  for (const char* word : {"<?xml", "<!DOCTYPE", "Gnuplot", "by gnuplot"})
    EXPECT_FALSE(holds(figure, word)) << word;
  EXPECT_THROW(html_figure("no picture", "p1", ""), std::invalid_argument);
  EXPECT_THROW(html_figure("<svg><path", "p1", ""), std::invalid_argument);
}

TEST(HtmlPage, LoadsAndRunsNothing) {
  const std::string page = html_page("a </title><script>", html_element("p", "body"));
  EXPECT_TRUE(page.starts_with("<!DOCTYPE html>"));
  EXPECT_TRUE(holds(page, "default-src 'none'"));
  EXPECT_TRUE(holds(page, "<title>a &lt;/title&gt;&lt;script&gt;</title>"));
  for (const char* word : {"<script", "http://", "https://", "@import", "url("})
    EXPECT_FALSE(holds(page, word)) << word;
}

}  // namespace
}  // namespace ballbar

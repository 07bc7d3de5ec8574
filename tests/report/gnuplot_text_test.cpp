#include "report/gnuplot_text.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <string>

namespace ballbar {
namespace {

TEST(QuotedText, CannotEndEarly) {
  struct Row {
    std::string text, quoted;
  };
  for (const Row& row : {
           Row{"lrmate-1", "'lrmate-1'"},
           Row{"", "''"},
           Row{"it's", "'it’s'"},
           Row{"'; system 'x", "'’; system ’x'"},
           Row{"a\nEOD\n!b", "'a EOD !b'"},
           Row{"a\r\tb", "'a  b'"},
           Row{std::string("a\0b", 3), "'a b'"},
           Row{"µm − °", "'µm − °'"},
           Row{"\x80\xC0\xAF", "'���'"},         // stray and overlong
           Row{"\xED\xA0\x80", "'���'"},         // a surrogate
           Row{"\xF4\x90\x80\x80", "'����'"},    // beyond the last code point
           Row{"cut \xE2\x82", "'cut ��'"},      // ends within a character
           Row{"\xC2\x85\xE2\x80\xA8", "'  '"},  // next line, line separator
           Row{"\xEF\xBF\xBE", "' '"},           // U+FFFE: not allowed in XML
           Row{"😀", "'😀'"},
       })
    EXPECT_EQ(gnuplot_quoted(row.text), row.quoted);
}

TEST(QuotedText, CutsWhatNoPictureCanShow) {
  const std::string quoted = gnuplot_quoted(std::string(100000, 'x'));
  EXPECT_EQ(quoted, "'" + std::string(160, 'x') + "…'");
  EXPECT_EQ(gnuplot_quoted(std::string(160, 'x')), "'" + std::string(160, 'x') + "'");
}

TEST(PlainNumber, IsShortAndHasADecimalPointInEveryLocale) {
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
  EXPECT_EQ(plain_number(1.5, 3), "1.5");
  EXPECT_EQ(plain_number(-2.0, 3), "-2");
  EXPECT_EQ(plain_number(100.0, 0), "100");
  EXPECT_EQ(plain_number(1e-9, 4), "0");
  EXPECT_EQ(plain_number(-1e-9, 4), "0");
  EXPECT_EQ(plain_number(0.12345, 4), "0.1235");
  EXPECT_EQ(plain_number(1e300, 4).size(), 301U);
  std::setlocale(LC_NUMERIC, before.c_str());
}

}  // namespace
}  // namespace ballbar

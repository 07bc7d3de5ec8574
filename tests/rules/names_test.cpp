#include "rules/names.hpp"

#include <gtest/gtest.h>

namespace ballbar {
namespace {

TEST(Names, TheNearestNameIsSuggested) {
  EXPECT_EQ(suggestion("ovalty_um", "circle"), "; did you mean 'ovality_um'?");
  EXPECT_EQ(suggestion("ovality_mm", "circle"), "; did you mean 'ovality_um'?");
  EXPECT_EQ(suggestion("straightnes_mz_um", "line"), "; did you mean 'straightness_mz_um'?");
  EXPECT_EQ(suggestion("directoin", "line"), "; did you mean 'direction'?");
  EXPECT_EQ(suggestion("limt_um", "line", {"limit_um"}), "; did you mean 'limit_um'?");
  EXPECT_EQ(suggestion("xyzzy", "circle"), "");
}

TEST(Names, LinesOfAWordLeaveOutCommentsAndPartsOfWords) {
  const std::string source =
      "-- word\n"
      "--[[ word\n"
      "word ]] local x = word\n"
      "local words = 'word -- not a comment' .. word\n"
      "--[==[ word ]] word ]==] word()\n"
      "local quote = '\\' -- word' -- word\n";
  EXPECT_EQ(lines_with(source, "word"), (std::vector<int>{3, 4, 4, 5, 6}));
  EXPECT_EQ(line_of(source, "word"), 3);
  EXPECT_EQ(line_of(source, "wor"), 0);
  EXPECT_EQ(line_of("--[[ never closed word", "word"), 0);
}

TEST(Names, TheReturnOfTheFileIsTheOneAtTheLeftEdge) {
  EXPECT_EQ(line_of_return("local function f()\n  return 1\nend\nreturn {}\n"), 4);
  EXPECT_EQ(line_of_return("return {}"), 1);
  EXPECT_EQ(line_of_return("  return {}"), 0);
}

}  // namespace
}  // namespace ballbar

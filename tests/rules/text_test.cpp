#include "rules/text.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace ballbar {
namespace {

TEST(Text, NumbersAreShort) {
  const std::pair<double, const char*> table[] = {
      {150.0, "150"}, {25.0, "25"}, {184.26, "184.3"},   {-184.26, "-184.3"}, {7.25, "7.25"},  {9.999, "10"},
      {0.0, "0"},     {-0.0, "0"},  {0.03124, "0.0312"}, {1e-9, "1e-09"},     {1e18, "1e+18"}, {1.5, "1.5"},
  };
  for (const auto& [value, text] : table) EXPECT_EQ(short_number(value), text);
}

TEST(Text, PlaceholdersAreFoundAndFilled) {
  const std::string text = "{a} and {b_2}, {a}!";
  EXPECT_EQ(placeholders(text), (std::vector<std::string>{"a", "b_2", "a"}));
  EXPECT_EQ(fill(text, [](const std::string& name) { return "<" + name + ">"; }), "<a> and <b_2>, <a>!");
  EXPECT_EQ(fill("none", [](const std::string&) { return "x"; }), "none");
}

TEST(Text, WhatIsFilledInIsNotFilledAgainAndStaysOnOneLine) {
  EXPECT_EQ(fill("{a}{b}", [](const std::string& name) { return name == "a" ? "{b}" : "1\n2"; }), "{b}1 2");
}

TEST(Text, BracesWithoutANameAreRefused) {
  for (const char* bad : {"{", "}", "{}", "{a", "a}", "{a b}", "{{a}}", "{a}}"})
    EXPECT_THROW(placeholders(bad), std::invalid_argument) << bad;
}

TEST(Text, OfALineIsWithoutItsIndent) {
  const std::string source = "first\n\t  second\r\n\nlast";
  EXPECT_EQ(text_of_line(source, 1), "first");
  EXPECT_EQ(text_of_line(source, 2), "second");
  for (const int line : {-1, 0, 3, 5, 9}) EXPECT_EQ(text_of_line(source, line), "") << line;
  EXPECT_EQ(text_of_line(source, 4), "last");
}

}  // namespace
}  // namespace ballbar

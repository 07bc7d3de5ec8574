#include "files/numbers.hpp"

#include <gtest/gtest.h>

#include <ctime>

namespace ballbar {
namespace {

TEST(Numbers, AreWholeAndFinite) {
  EXPECT_EQ(number_from("12"), 12.0);
  EXPECT_EQ(number_from(" +1.5\t"), 1.5);
  EXPECT_EQ(number_from("-1.5e-3"), -1.5e-3);
  EXPECT_EQ(number_from("1,5", ','), 1.5);
  for (const char* text :
       {"", " ", "+", "-", "+-1", "1.5mm", "1 2", "1,5", "1.2.3", "nan", "inf", "1e999", "0x10", "."})
    EXPECT_FALSE(number_from(text)) << text;
  EXPECT_FALSE(number_from("1.5", ',')) << "then a point may separate thousands";
  EXPECT_FALSE(number_from("1,500,3", ','));
}

TEST(Units, AreKnownByTheirOneName) {
  EXPECT_EQ(metres_per("um"), 1e-6);
  EXPECT_EQ(metres_per("in"), 0.0254);
  EXPECT_EQ(seconds_per("ms"), 1e-3);
  EXPECT_FALSE(metres_per("UM"));
  EXPECT_FALSE(metres_per(""));
  EXPECT_FALSE(seconds_per("um"));
}

TEST(Times, AreThoseOfTheCLibrary) {
  struct Row {
    const char* text;
    int year, month, day, hour, minute, second;
    int micro;
  };
  for (const Row& row : {Row{"1970-01-01T00:00:00Z", 1970, 1, 1, 0, 0, 0, 0},
                         Row{"2026-03-11T09:00:00", 2026, 3, 11, 9, 0, 0, 0},
                         Row{" 2024-02-29 23:59:59.25 ", 2024, 2, 29, 23, 59, 59, 250000},
                         Row{"2026-03-11T09:30Z", 2026, 3, 11, 9, 30, 0, 0},
                         Row{"2026-01-01T00:30:00+01:00", 2025, 12, 31, 23, 30, 0, 0},
                         Row{"2026-12-31T23:30:00.123456-0130", 2027, 1, 1, 1, 0, 0, 123456},
                         Row{"1969-12-31T23:59:59", 1969, 12, 31, 23, 59, 59, 0}}) {
    std::tm parts{};
    parts.tm_year = row.year - 1900;
    parts.tm_mon = row.month - 1;
    parts.tm_mday = row.day;
    parts.tm_hour = row.hour;
    parts.tm_min = row.minute;
    parts.tm_sec = row.second;
    EXPECT_EQ(time_us_from(row.text), timegm(&parts) * 1'000'000 + row.micro) << row.text;
  }
}

TEST(Times, OfAnyOtherFormAreRefused) {
  for (const char* text :
       {"", "yesterday", "11/03/2026 09:00:00", "2026-03-11", "2026-3-11T09:00:00", "2026-02-30T09:00:00",
        "2026-13-01T09:00:00", "2026-03-11T24:00:00", "2026-03-11T09:60:00", "2026-03-11T09:00:61",
        "2026-03-11T09:00:00.", "2026-03-11T09:00:00X", "2026-03-11T09:00:00+25:00", "2026-03-11T09:00:00 PM",
        "2026-03-11T09:00:00+", "20260311T090000", "2026-03-11T09:00:00.1234567Z"})
    EXPECT_FALSE(time_us_from(text)) << text;
}

}  // namespace
}  // namespace ballbar

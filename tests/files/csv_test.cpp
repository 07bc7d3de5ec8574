#include "files/csv.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/error.hpp"
#include "files/b5r.hpp"

namespace ballbar {
namespace {

CsvOptions mapped(const std::string& columns) {
  CsvOptions options;
  options.columns = csv_columns_from(columns);
  return options;
}

std::string why_refused(const std::string& bytes, const CsvOptions& options = {}) {
  try {
    read_csv(bytes, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.cause(), Cause::kInput);
    return error.what();
  }
  return "nothing was wrong";
}

void expect_near(const std::vector<double>& found, const std::vector<double>& wanted) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 1e-15) << i;
}

TEST(Csv, IsReadByTheNamesOfItsFirstLine) {
  const CsvReadings bar =
      read_csv("time_s,angle_deg,deviation_um,in_measured_arc\n0.5,1,12.5,1\n1.5,,-3,0\n", {});
  expect_near(bar.time, {0.5, 1.5});
  expect_near(bar.deviation, {12.5e-6, -3e-6});
  EXPECT_TRUE(bar.position.empty() && bar.axis.empty());
  const CsvReadings line = read_csv(
      "\xEF\xBB\xBF"
      "axis;position_mm;deviation_nm\r\nX;100;5\r\n\r\n# pause\r\nZ;\"200\";6\r\n",
      {});
  EXPECT_EQ(line.axis, (std::vector<char>{'X', 'Z'}));
  expect_near(line.position, {0.1, 0.2});
  expect_near(line.deviation, {5e-9, 6e-9});
}

TEST(Csv, IsReadByAMapOfColumnsByNumberOrName) {
  const std::string file = "Report of 3 March\nPosition (mm),Error,Target\n0,1.5,0\n10,2.5,10\n";
  CsvOptions by_name = mapped("position_mm=Position (mm), deviation_um=Error");
  by_name.skip = 1;
  CsvOptions by_number = mapped("deviation=2,position_mm=1");
  by_number.skip = 1;
  by_number.unit = "um";
  for (const CsvOptions& options : {by_name, by_number}) {
    const CsvReadings found = read_csv(file, options);
    expect_near(found.position, {0.0, 0.01});
    expect_near(found.deviation, {1.5e-6, 2.5e-6});
  }
  EXPECT_EQ(read_csv("1,2\n3,4\n", mapped("time_ms=1,deviation_mm=2")).time.size(), 2U) << "no names at all";
}

TEST(Csv, MayBeSeparatedByTabsAndHaveDecimalCommas) {
  CsvOptions options;
  options.decimal = ',';
  expect_near(read_csv("time_s\tdeviation_um\n0,5\t1,25\n", options).deviation, {1.25e-6});
  expect_near(read_csv("time_s;deviation_um\n0,5;1,25\n", options).time, {0.5});
  EXPECT_NE(why_refused("time_s;deviation_um\n0,5;1,25\n").find("--decimal comma"), std::string::npos);
  EXPECT_NE(why_refused("time_s,deviation_um\n0,5,1,25\n", options).find("cannot separate"),
            std::string::npos);
}

TEST(Csv, SaysWhatIsWrongAndWhere) {
  CsvOptions mm;
  mm.unit = "mm";
  struct Row {
    std::string bytes;
    CsvOptions options;
    std::string says;
  };
  for (const Row& row : {
           Row{"", {}, "holds no readings"},
           Row{"\n# nothing\n", {}, "holds no readings"},
           Row{"time_s,deviation_um\n", {}, "no readings"},
           Row{"time_s,deviation_um\n1,2\n3\n",
               {},
               "line 3: has 1 columns, 2 are needed: is the file cut short"},
           Row{"time_s,deviation_um\n1,2\n3,4", {}, "line 3: has no end: is the file cut short"},
           Row{"time_s,deviation_um\n1,2\n3,four\n", {}, "line 3, column 2 (deviation): 'four' is no number"},
           Row{"time_s,deviation_um\n1,inf\n", {}, "'inf' is no number"},
           Row{"time_s,deviation_um\n1,\"2\n", {}, "line 2: a quote is not closed"},
           Row{"1,2\n3,4\n", {}, "no column is named deviation_UNIT"},
           Row{"time_s,deviation\n1,2\n", {}, "unit of the deviation is not stated"},
           Row{"time,deviation_um\n1,2\n", {}, "unit of the time is not stated"},
           Row{"time_s,deviation_um\n1,2\n", mm, "in um by the name of its column, and in mm by --unit"},
           Row{"deviation_um,deviation_mm\n1,2\n", {}, "two columns hold the deviation"},
           Row{"a,b,a\n1,2,3\n", mapped("deviation_um=a"), "2 columns are named 'a'"},
           Row{"a,b\n1,2\n", mapped("deviation_um=c"), "no column is named 'c'; there are 'a', 'b'"},
           Row{"a,b\n1,2\n", mapped("time_s=a"), "--columns does not say which column holds the deviation"},
           Row{"a,b\n1,2\n3,4\n", mapped("deviation_um=3"), "has 2 columns, 3 are needed"},
           Row{"axis,position_mm,deviation_um\nQ,1,2\n", {}, "'Q' is no axis"},
           Row{std::string("time_s,deviation_um\n1,2\n\0\n", 27), {}, "binary"},
           Row{std::string("\xFF\xFEt\0i\0", 6), {}, "UTF-16"},
           Row{"<html>\n<p>1,2</p>\n</html>\n", {}, "no column is named deviation_UNIT"},
       }) {
    const std::string said = why_refused(row.bytes, row.options);
    EXPECT_NE(said.find(row.says), std::string::npos) << row.bytes << "\n" << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
}

TEST(Csv, HasAMapThatSaysWhatIsWrongInIt) {
  struct Row {
    const char *map, *says;
  };
  for (const Row& row :
       {Row{"", "'' is not QUANTITY_UNIT=COLUMN"}, Row{"deviation_um", "is not QUANTITY"},
        Row{"length_um=1", "is not QUANTITY"}, Row{"deviation_s=1", "is not QUANTITY"},
        Row{"deviation_um=", "names no column"}, Row{"time_s=1,time_ms=2", "the time stands twice"}})
    try {
      csv_columns_from(row.map);
      ADD_FAILURE() << row.map;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(row.says), std::string::npos) << error.what();
    }
}

TEST(Csv, HasAStatedMaximumOfRows) {
  std::string rows = "deviation_um\n";
  for (std::size_t i = 0; i < kMaxReadings; ++i) rows += "1\n";
  EXPECT_EQ(read_csv(rows, {}).deviation.size(), kMaxReadings);
  EXPECT_NE(why_refused(rows + "1\n").find("more than 250000 rows"), std::string::npos);
}

TEST(Csv, WithAnyByteChangedOrCutIsReadOrRefused) {
  std::string whole = "time_s,position_mm,deviation_um,axis\n";
  for (int i = 0; i < 20; ++i) whole += std::to_string(i) + "," + std::to_string(i * 10) + ",-1.5e1,X\n";
  for (unsigned seed = 1; seed <= 2000; ++seed) {
    std::mt19937 random(seed);
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::string bytes = whole.substr(0, random() % 2 == 0 ? whole.size() : random() % whole.size());
    for (unsigned k = 0; k < seed % 4 && !bytes.empty(); ++k)
      bytes[random() % bytes.size()] = static_cast<char>(random() % 256);
    why_refused(bytes);  // another kind of exception fails the test
  }
}

}  // namespace
}  // namespace ballbar

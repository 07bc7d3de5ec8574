#include "files/b5r.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/error.hpp"

namespace ballbar {
namespace {

/// Element names as two public readers of such files use them; the frame around them is ours.
const std::string kWhole = R"(<?xml version="1.0" encoding="utf-8"?>
<BALLBAR_RESULT>
  <TEST_SPEC NAME="XY 360 100mm"/>
  <PLANE TEST_PLANE="XY"/>
  <DATE_STARTED>2022-10-11T12:09:24</DATE_STARTED>
  <OPERATOR>A. &amp; B.</OPERATOR>
  <MACHINE_TESTED NAME="LR Mate"/>
  <BALLBAR><SERIAL_NUMBER>H12345</SERIAL_NUMBER><LAST_CALIBRATED>2022-01-02</LAST_CALIBRATED></BALLBAR>
  <RUN><RUN_DIRECTION>CCW</RUN_DIRECTION><FEEDRATE>1000</FEEDRATE>
    <READINGS>0.1 -0.25
      1e-1 3</READINGS></RUN>
  <RUN><RUN_DIRECTION> CW </RUN_DIRECTION><READINGS>-4 <!-- a pause --> 5</READINGS></RUN>
  <FEATURE NAME="Circularity"><DT>12.3</DT></FEATURE>
</BALLBAR_RESULT>
)";

std::string why(const std::string& bytes) {
  try {
    read_b5r(bytes);
  } catch (const Error& error) {
    EXPECT_EQ(error.cause(), Cause::kInput);
    return error.what();
  }
  return "nothing was wrong";
}

std::string with(const std::string& from, const std::string& to) {
  std::string text = kWhole;
  text.replace(text.find(from), from.size(), to);
  return text;
}

TEST(B5r, HasRunsWithTheirDirectionsAndWhatTheFileSaysOfItself) {
  const B5rFile file = read_b5r(kWhole);
  ASSERT_EQ(file.runs.size(), 2U);
  EXPECT_EQ(file.runs[0].direction, 1);
  EXPECT_EQ(file.runs[0].readings, (std::vector<double>{0.1, -0.25, 0.1, 3}));
  EXPECT_EQ(file.runs[1].direction, -1);
  EXPECT_EQ(file.runs[1].readings, (std::vector<double>{-4, 5}));
  EXPECT_EQ(file.test, "XY 360 100mm");
  EXPECT_EQ(file.plane, "XY");
  EXPECT_EQ(file.machine, "LR Mate");
  EXPECT_EQ(file.started, "2022-10-11T12:09:24");
  EXPECT_EQ(file.person, "A. & B.");
  EXPECT_EQ(file.serial, "H12345");
  EXPECT_EQ(file.calibrated, "2022-01-02");
}

TEST(B5r, MayBeUtf16AsWindowsWritesIt) {
  std::string wide = "\xFF\xFE";
  for (const char c : with("encoding=\"utf-8\"", "encoding=\"utf-16\"")) (wide += c) += '\0';
  EXPECT_EQ(read_b5r(wide).runs[0].readings.size(), 4U);
}

TEST(B5r, NeedNotSayMoreThanItsRuns) {
  const B5rFile file = read_b5r("<R><RUN_DIRECTION>CW</RUN_DIRECTION><READINGS>1 2</READINGS></R>");
  EXPECT_EQ(file.runs.size(), 1U);
  EXPECT_EQ(file.started, "");
}

TEST(B5r, SaysWhatIsWrong) {
  struct Row {
    std::string bytes, says;
  };
  for (const Row& row : {
           Row{"", "no whole XML"},
           Row{"time_s,deviation_um\n1,2\n", "no whole XML"},
           Row{std::string("\x00\x01\x02 EDA1DA01", 12), "no whole XML"},
           Row{kWhole.substr(0, kWhole.size() / 2), "cut short"},
           Row{with("</OPERATOR>", "</PERSON>"), "line 6: is no whole XML"},
           Row{"<html><body>Not found</body></html>", "holds no READINGS"},
           Row{with("<RUN_DIRECTION>CCW</RUN_DIRECTION>", ""), "READINGS without a RUN_DIRECTION"},
           Row{with("<RUN_DIRECTION>CCW", "<RUN_DIRECTION>left"), "RUN_DIRECTION is 'left'"},
           Row{with("0.1 -0.25", "0.1 -0,25"), "reading 2 of READINGS is '-0,25', no number"},
           Row{with("0.1 -0.25", "0.1 nan"), "reading 2 of READINGS is 'nan'"},
           Row{with("-4 ", "<R>-4</R> "), "READINGS holds the element 'R'"},
           Row{with("-4 <!-- a pause --> 5", "  "), "READINGS holds no readings"},
       }) {
    const std::string said = why(row.bytes);
    EXPECT_NE(said.find(row.says), std::string::npos) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
}

TEST(B5r, IsReadWholeOrNotAtAllWhereverItIsCut) {
  const std::size_t root_end = kWhole.rfind('>');
  for (std::size_t size = 0; size <= root_end; ++size)
    EXPECT_NE(why(kWhole.substr(0, size)), "nothing was wrong") << size << " bytes of " << kWhole.size();
}

TEST(B5r, WithAnyByteChangedIsReadOrRefused) {
  for (unsigned seed = 1; seed <= 2000; ++seed) {
    std::mt19937 random(seed);
    std::string bytes = kWhole;
    for (unsigned k = 0; k <= seed % 4; ++k)
      bytes[random() % bytes.size()] = static_cast<char>(random() % 256);
    SCOPED_TRACE("seed " + std::to_string(seed));
    why(bytes);  // another kind of exception fails the test
  }
}

TEST(B5r, HasStatedMaxima) {
  std::string deep;
  for (int i = 0; i < 200'000; ++i) deep += "<a>";
  EXPECT_NE(why(deep).find("no whole XML"), std::string::npos);
  for (int i = 0; i < 200'000; ++i) deep += "</a>";
  EXPECT_NE(why(deep).find("holds no READINGS"), std::string::npos) << "as deep as it likes";
  std::string many = "<R><RUN_DIRECTION>CW</RUN_DIRECTION><READINGS>";
  for (std::size_t i = 0; i <= kMaxReadings; ++i) many += "1 ";
  EXPECT_NE(why(many + "</READINGS></R>").find("more than 250000 numbers"), std::string::npos);
  std::string runs = "<R>";
  for (int i = 0; i < 101; ++i) runs += "<RUN_DIRECTION>CW</RUN_DIRECTION><READINGS>1 2</READINGS>";
  EXPECT_NE(why(runs + "</R>").find("more than 100 runs"), std::string::npos);
}

}  // namespace
}  // namespace ballbar

#include "files/poses_csv.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "core/error.hpp"

namespace ballbar {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;

TEST(PosesCsvTest, ReadsWhatTheContractNames) {
  const PoseSet set = read_poses(
      "# from the tracker\n"
      "q1_deg,q2_deg,c1_deg,c2_deg,x_mm,y_mm,z_mm,series,point,time_s,payload_kg,temperature_c,direction,"
      "held_out,who\n"
      "10,-20,10.1,-20.1,1000,2000,-3000,A,ball,12.5,3,21.5,-1,0,me\n"
      "\n"
      "11,-21,11.1,-21.1,1001,2001,-3001,A,,,,,,1,\"you\"\n",
      2);
  EXPECT_FALSE(set.lengths);
  EXPECT_TRUE(set.held_out_column);
  ASSERT_EQ(set.poses.size(), 2U);
  const Pose& first = set.poses[0];
  EXPECT_EQ(first.row, 1);
  EXPECT_DOUBLE_EQ(first.joints[1], -20.0 * kDeg);
  EXPECT_DOUBLE_EQ(first.command[0], 10.1 * kDeg);
  EXPECT_EQ(first.point, (Vec3{1.0, 2.0, -3.0}));
  EXPECT_EQ(first.series, "A");
  EXPECT_EQ(first.tool, "ball");
  EXPECT_EQ(first.time, 12.5);
  EXPECT_EQ(first.payload, 3.0);
  EXPECT_EQ(first.temperature, 21.5);
  EXPECT_EQ(first.direction, -1);
  EXPECT_FALSE(first.held_out);
  const Pose& second = set.poses[1];
  EXPECT_EQ(second.row, 2);
  EXPECT_TRUE(second.held_out);
  EXPECT_FALSE(second.time.has_value());
  EXPECT_EQ(second.direction, 0);
}

TEST(PosesCsvTest, ReadsLengthsAndOtherSeparators) {
  const PoseSet set = read_poses("q1_deg;length_mm\n5;1234.5\n", 1);
  EXPECT_TRUE(set.lengths);
  EXPECT_DOUBLE_EQ(set.poses.front().length, 1.2345);
}

struct Bad {
  const char* text;
  const char* says;
};

TEST(PosesCsvTest, RefusesWhatItCannotMean) {
  const Bad table[] = {
      {"", "holds no heading"},
      {"q1_deg,q2_deg,x_mm,y_mm,z_mm\n", "no poses"},
      {"q1_deg,x_mm,y_mm,z_mm\n1,2,3,4\n", "1 of the columns q1_deg.. and the robot has 2 joints"},
      {"q1_deg,q2_deg,c1_deg,x_mm,y_mm,z_mm\n1,2,3,4,5,6\n", "give all or none"},
      {"q1_deg,q2_deg,x_mm,y_mm\n1,2,3,4\n", "lacks x_mm, y_mm, z_mm"},
      {"q1_deg,q2_deg,x_mm,y_mm,z_mm,length_mm\n1,2,3,4,5,6\n", "which was measured"},
      {"q1_deg,q2_deg,length_mm,length_mm\n1,2,3,4\n", "two columns are named 'length_mm'"},
      {"q1_deg,q2_deg,length_mm\n1,2\n", "line 2: has 2 columns, the heading 3"},
      {"q1_deg,q2_deg,length_mm\n1,two,3\n", "line 2, q2_deg: 'two' is no number"},
      {"q1_deg;q2_deg;length_mm\n1;2,5;3\n", "write decimals with a point"},
      {"q1_deg,q2_deg,length_mm\n1,1e6,3\n", "can hardly be degrees"},
      {"q1_deg,q2_deg,length_mm\n1,2,-3\n", "a length above 0"},
      {"q1_deg,q2_deg,length_mm\n1,2,\n", "is no number"},
      {"q1_deg,q2_deg,length_mm,held_out\n1,2,3,yes\n", "is no number"},
      {"q1_deg,q2_deg,length_mm,held_out\n1,2,3,2\n", "neither 0 nor 1"},
      {"q1_deg,q2_deg,length_mm,direction\n1,2,3,5\n", "none of 1, -1 and 0"},
      {"q1_deg,q2_deg,length_mm,payload_kg\n1,2,3,-1\n", "payload_kg: must be from 0"},
      {"q1_deg,q2_deg,length_mm\n1,2,3", "cut short"},
      {"\xFF\xFEq1", "UTF-16"},
  };
  for (const Bad& bad : table) {
    SCOPED_TRACE(bad.text);
    try {
      read_poses(bad.text, 2);
      ADD_FAILURE() << "was taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.cause(), Cause::kInput);
      EXPECT_NE(std::string(error.what()).find(bad.says), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace ballbar

// Circles in three planes, from a simulated robot by way of a log: one fit in summary and report.

#include <gtest/gtest.h>

#include <cmath>

#include "support/tool_test.hpp"

namespace ballbar {
namespace {

using nlohmann::json;
using test::ballbar;
using test::kScripts;
using test::Outcome;

/// The shipped robot with one set-up: all of XY, 220 degrees of the planes that stand upright.
std::string three_planes() {
  const std::string circle =
      "[[robot.test]]\nkind = \"circle\"\ncentre_mm = [380.0, -320.0, -251.0]\n"
      "radius_mm = 100.0\nfeed_mm_s = 55.33\novershoot_deg = 10.0\ntool_rpy_deg = [180, 0, 0]\n";
  return "[rules]\ndirectory = \".\"\n[[robot]]\nname = \"lrmate-1\"\nurdf = \"" + kScripts +
         "/robots/lrmate200ic.urdf\"\nbase = \"base\"\ntip = \"tcp\"\njoint_convention = \"fanuc\"\n" +
         circle + "name = \"XY\"\n" + circle + "name = \"YZ\"\nnormal = [1, 0, 0]\narc_deg = [-20, 220]\n" +
         circle + "name = \"ZX\"\nnormal = [0, 1, 0]\nfirst_axis = [0, 0, 1]\narc_deg = [-110, 220]\n";
}

TEST(ToolVolumetric, ThreePlanesOfOneSetUpAreOneFitInSummaryAndReport) {
  const test::TempDir dir;
  const auto path = [&](const std::string& name) { return dir.path() + "/" + name; };
  test::write_file(path("c.toml"), three_planes());
  const Outcome driven = ballbar({"simulate", "--config", path("c.toml"), "--effect",
                                  "joint_zero_offset,joint=3,offset_deg=0.02", "--effect",
                                  "joint_zero_offset,joint=4,offset_deg=0.02", "-o", path("x.lcm")});
  ASSERT_EQ(driven.code, 0) << driven.err << driven.out;
  const Outcome replayed =
      ballbar({"replay", path("x.lcm"), "--config", path("c.toml"), "--db", path("x.db")});
  ASSERT_NE(replayed.out.find("6 runs stored, 6 of them ok"), std::string::npos) << replayed.out;

  const json summary = json::parse(ballbar({"summary", "--json", "--db", path("x.db")}).out);
  const json* bar = nullptr;
  for (const json& entry : summary["volumetric"])
    if (entry["source"] == "bar") bar = &entry;
  ASSERT_NE(bar, nullptr) << summary["volumetric"];
  EXPECT_EQ((*bar)["tests"], json::parse(R"(["XY", "YZ", "ZX"])"));
  EXPECT_EQ((*bar)["runs"], 6);
  // The full circle alone knows the squareness of XY by its second harmonic: -2 b2 / R (metrology.md 1.2).
  const json exported = json::parse(ballbar({"export", "--json", "--db", path("x.db")}).out);
  double sine_um = 0.0;
  for (const json& run : exported["runs"])
    if (run["test"] == "XY") sine_um += run["harmonics"][1]["sin_um"].get<double>() / 2.0;  // both ways
  const auto found = [&](const char* name) { return (*bar)[name].get<double>(); };
  EXPECT_GT(std::abs(sine_um), 10.0) << "this robot has one to find";
  EXPECT_NEAR(found("squareness_xy_um_per_m"), -2.0 * sine_um / 0.1, 1.0);
  for (const char* name :
       {"squareness_xy_um_per_m_sd", "squareness_yz_um_per_m_sd", "squareness_zx_um_per_m_sd",
        "scaling_x_um_per_m_sd", "scaling_y_um_per_m_sd", "scaling_z_um_per_m_sd"})
    EXPECT_GT(found(name), 0.0) << name;

  const Outcome text = ballbar({"summary", "--db", path("x.db")});
  EXPECT_NE(text.out.find("Volumetric analysis"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("squareness YZ"), std::string::npos);
  ASSERT_EQ(ballbar({"report", "--db", path("x.db"), "-o", path("p.html")}).code, 0);
  const std::string page = test::read_file(path("p.html"));
  EXPECT_NE(page.find("Volumetric analysis"), std::string::npos);
  EXPECT_NE(page.find("scaling Z"), std::string::npos);
  EXPECT_NE(page.find("calculated feed [mm/s]"), std::string::npos);
  EXPECT_NE(page.find("positional tolerance [µm]"), std::string::npos);

  const json two = json::parse(ballbar({"summary", "--test", "XY", "--json", "--db", path("x.db")}).out);
  EXPECT_TRUE(two["volumetric"].empty()) << "one plane alone";
}

}  // namespace
}  // namespace ballbar

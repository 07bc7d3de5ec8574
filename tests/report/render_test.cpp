#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "report/plot.hpp"

namespace ballbar {
namespace {

namespace fs = std::filesystem;

class Render : public ::testing::Test {
 protected:
  Render() {
    std::string name = (fs::temp_directory_path() / "ballbar-plot-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~Render() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Why `xml` is not well-formed, or "": tags nest, text holds no bare '<' or '&', attributes are quoted.
std::string flaw_of(const std::string& xml) {
  std::vector<std::string> open;
  for (std::size_t i = 0; i < xml.size(); ++i) {
    const unsigned char c = static_cast<unsigned char>(xml[i]);
    if (c < 0x20 && c != '\n' && c != '\t' && c != '\r') return "control character";
    if (c == '&') {
      const std::size_t end = xml.find(';', i);
      if (end == std::string::npos || end - i > 8) return "bare & at " + std::to_string(i);
    }
    if (c != '<') continue;
    const std::size_t end = xml.find('>', i);
    if (end == std::string::npos) return "tag without end";
    const std::string tag = xml.substr(i + 1, end - i - 1);
    if (tag.find('<') != std::string::npos) return "bare < in " + tag;
    i = end;
    if (tag[0] == '?' || tag[0] == '!') continue;
    if (tag[0] == '/') {
      if (open.empty() || tag.substr(1) != open.back()) return "unexpected end of " + tag;
      open.pop_back();
    } else if (std::isalpha(static_cast<unsigned char>(tag[0])) == 0) {
      return "no name in <" + tag;
    } else if (tag.back() != '/') {
      open.push_back(tag.substr(0, tag.find_first_of(" \t\r\n")));
    }
  }
  return open.empty() ? "" : "no end of " + open.back();
}

PolarPlot circle(const std::string& words) {
  PolarPlot plot{.title = words, .subtitle = words, .notes = {words}};
  for (const int direction : {1, -1, 0}) {
    PolarTrace trace{words, direction, {}, {}};
    for (int i = 0; i <= 90; ++i) {
      trace.angle_rad.push_back(i * 0.07);
      trace.deviation_um.push_back(direction * 10.0 + 20.0 * std::cos(0.14 * i));
    }
    plot.traces.push_back(trace);
  }
  return plot;
}

LinePlot line(const std::string& words) {
  return {.title = words,
          .subtitle = words,
          .axis = words,
          .traces = {{words, 1, {0, 10, 20}, {1, -3, 2}}, {words, -1, {0, 10, 20}, {2, -2, 3}}},
          .notes = {words}};
}

TEST_F(Render, TheFlawFinderFindsFlaws) {
  EXPECT_EQ(flaw_of("<?xml?><svg a='1'><g/><text>x &amp; y</text></svg>"), "");
  for (const char* bad : {"<svg>", "<svg></g>", "<svg>a & b</svg>", "<svg>a < b</svg>", "<svg>\x01</svg>"})
    EXPECT_NE(flaw_of(bad), "") << bad;
}

TEST_F(Render, GivesAWellFormedSvgThatHoldsTheWords) {
  render(polar_script(circle("lrmate-1 test A")), path("polar.svg"));
  render(line_script(line("lrmate-1 test Y")), path("line.svg"));
  for (const char* name : {"polar.svg", "line.svg"}) {
    const std::string svg = content(path(name));
    EXPECT_EQ(flaw_of(svg), "") << name;
    EXPECT_NE(svg.find("lrmate-1 test"), std::string::npos) << name;
    EXPECT_NE(svg.find("µm"), std::string::npos) << name;
  }
  EXPECT_NE(content(path("polar.svg")).find("10 µm/div"), std::string::npos);
}

TEST_F(Render, GivesTheSamePictureTwice) {
  render(polar_script(circle("A")), path("1.svg"));
  render(polar_script(circle("A")), path("2.svg"));
  EXPECT_EQ(content(path("1.svg")), content(path("2.svg")));
}

TEST_F(Render, GivesAPng) {
  render(line_script(line("Y")), path("line.png"));
  EXPECT_EQ(content(path("line.png")).substr(0, 8), "\x89PNG\r\n\x1a\n");
}

TEST_F(Render, TakesNastyNamesAsWordsOnly) {
  const std::string trap = path("trap");
  const std::vector<std::string> names = {
      "'; system('touch " + trap + "'); print '",
      "\"; system(\"touch " + trap + "\"); print \"",
      "`touch " + trap + "`",
      "$(touch " + trap + ")",
      "x\n!touch " + trap + "\n",
      "x\nEOD\nsystem('touch " + trap + "')\n",
      "x\\\n!touch " + trap,
      "\\",
      "''\\'",
      "@trap {/Symbol a}_b^c~d &amp; &{x}",
      "<script>alert(1)</script> </text> ]]> & &lt; \"",
      "%s %d %n %",
      "$trace0 #{x}",
      "\xFF\xFE broken \xC3",
      std::string("nul\0here", 8),
      std::string(5000, 'W'),
  };
  for (const std::string& name : names) {
    for (const char* ending : {".svg", ".png"}) {
      ASSERT_NO_THROW(render(polar_script(circle(name)), path(std::string("polar") + ending))) << name;
      ASSERT_NO_THROW(render(line_script(line(name)), path(std::string("line") + ending))) << name;
    }
    EXPECT_EQ(flaw_of(content(path("polar.svg"))), "") << name;
    EXPECT_EQ(flaw_of(content(path("line.svg"))), "") << name;
    ASSERT_FALSE(fs::exists(trap)) << name;
  }
}

TEST_F(Render, TakesANastyPathAsAPathOnly) {
  const std::string name = "a'; print \"b\" `c` $(d).svg";
  render(polar_script(circle("A")), path(name));
  EXPECT_TRUE(fs::exists(path(name)));
  EXPECT_EQ(files(), 1U);
}

TEST_F(Render, RefusesAnotherEnding) {
  for (const char* name : {"x.pdf", "x", ".svg.txt", "svg"}) try {
      render(polar_script(circle("A")), path(name));
      FAIL() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.cause(), Cause::kInput);
    }
  EXPECT_EQ(files(), 0U);
}

TEST_F(Render, SaysWhatToInstallWhereGnuplotIsMissing) {
  const std::string before = std::getenv("PATH");
  ::setenv("PATH", folder_.c_str(), 1);
  try {
    render(polar_script(circle("A")), path("x.svg"));
    ADD_FAILURE() << "drew without gnuplot";
  } catch (const Error& error) {
    EXPECT_EQ(error.cause(), Cause::kWorld);
    EXPECT_NE(std::string(error.what()).find("install gnuplot-nox"), std::string::npos) << error.what();
  }
  ::setenv("PATH", before.c_str(), 1);
  EXPECT_EQ(files(), 0U);
}

TEST_F(Render, KeepsTheOldPictureWhereGnuplotFails) {
  std::ofstream(path("x.svg")) << "old";
  try {
    render({.width = 100, .height = 100, .text = "set nonsense\n"}, path("x.svg"));
    ADD_FAILURE() << "gnuplot took nonsense";
  } catch (const Error& error) {
    EXPECT_EQ(error.cause(), Cause::kWorld);
    EXPECT_NE(std::string(error.what()).find(path("x.svg")), std::string::npos) << error.what();
  }
  EXPECT_EQ(content(path("x.svg")), "old");
  EXPECT_EQ(files(), 1U);
}

TEST_F(Render, SaysWhichFileItCannotWrite) {
  try {
    render(polar_script(circle("A")), path("missing/x.svg"));
    ADD_FAILURE() << "wrote into a folder that is not there";
  } catch (const Error& error) {
    EXPECT_EQ(error.cause(), Cause::kWorld);
    EXPECT_NE(std::string(error.what()).find("missing/x.svg"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace ballbar

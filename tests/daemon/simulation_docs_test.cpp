// docs/simulation.md is true: every command on it runs as it stands and prints what the page shows.

#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>

#include "support/tool_test.hpp"

namespace ballbar {
namespace {

namespace fs = std::filesystem;

struct Example {
  std::string commands;
  std::string shown;  // what the page says they print
};

/// The blocks ```sh of the page, each with the block ```text that follows it.
std::vector<Example> examples_of(const std::string& page) {
  std::vector<Example> examples;
  std::istringstream lines(page);
  std::string* block = nullptr;
  for (std::string line; std::getline(lines, line);) {
    if (line == "```sh")
      block = &examples.emplace_back().commands;
    else if (line == "```text")
      block = &examples.back().shown;
    else if (line == "```")
      block = nullptr;
    else if (block)
      *block += line + "\n";
  }
  return examples;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;)
    words.push_back(word.back() == ',' ? word.substr(0, word.size() - 1) : word);
  return words;
}

std::optional<double> number(const std::string& word) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return {};
  return value;
}

/// Word for word; numbers to the digits of the tables, for the last ones may differ from machine to machine.
void expect_alike(const std::string& printed, const std::string& shown) {
  const std::vector<std::string> found = words_of(printed), expected = words_of(shown);
  ASSERT_EQ(found.size(), expected.size()) << printed;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::optional<double> value = number(expected[i]);
    if (value && number(found[i])) {
      EXPECT_NEAR(*number(found[i]), *value, 0.011) << "word " << i << " of\n" << printed;
    } else {
      EXPECT_EQ(found[i], expected[i]) << "word " << i << " of\n" << printed;
    }
  }
}

class SimulationDocs : public testing::Test {
 protected:
  test::Outcome shell(const std::string& commands) const {
    const std::string build = fs::path(test::kBallbar).parent_path().string();
    return test::run({"sh", "-c",
                      "cd '" BALLBAR_SOURCE_DIR "' && PATH='" + build + "':$PATH && TMPDIR='" + dir.path() +
                          "'\n" + commands});
  }
  test::TempDir dir;
};

TEST_F(SimulationDocs, EveryCommandPrintsWhatThePageShows) {
  const std::vector<Example> examples =
      examples_of(test::read_file(BALLBAR_SOURCE_DIR "/docs/simulation.md"));
  ASSERT_GT(examples.size(), 8u);
  const std::string words = examples.front().commands;  // which the others use
  for (std::size_t i = 1; i < examples.size(); ++i) {
    SCOPED_TRACE(examples[i].commands);
    const test::Outcome outcome = shell(words + examples[i].commands);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.err, "");
    expect_alike(outcome.out, examples[i].shown);
  }
  for (const std::string picture : {"simulation.svg", "simulation-joints.svg"})
    EXPECT_EQ(test::read_file(dir.path() + "/" + picture).substr(0, 5), "<?xml") << picture;
}

TEST_F(SimulationDocs, WhatItsSentencesSayIsSo) {
  const std::string words =
      examples_of(test::read_file(BALLBAR_SOURCE_DIR "/docs/simulation.md")).at(0).commands;
  const auto runs = [&](const std::string& options) {
    const test::Outcome outcome = shell(words + "ballbar simulate $robot --json " + options);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out)["runs"];
  };
  const auto amplitude = [](const nlohmann::json& run, int order) {
    return run["bar_harmonics"][static_cast<std::size_t>(order)]["amplitude_um"].get<double>();
  };
  const nlohmann::json peanuts = runs("$table1 --test A,B --direction +1 --centre fitted");
  double all = 0.0;
  for (int k = 1; k <= 10; ++k) {
    all += amplitude(peanuts[0], k);
    EXPECT_NEAR(amplitude(peanuts[0], k), amplitude(peanuts[1], k), 1e-9) << "A equals B in order " << k;
  }
  EXPECT_NEAR(amplitude(peanuts[0], 2) / all, 0.87, 0.005);
  const double turned =
      peanuts[0]["ovality_axis_deg"].get<double>() - peanuts[1]["ovality_axis_deg"].get<double>();
  const double between = 2.0 * std::atan2(320.0, 380.0) * 180.0 / std::numbers::pi;
  EXPECT_NEAR(180.0 - turned, between, 1e-3) << "the lobes turn with J1";

  const nlohmann::json eccentric =
      runs("--effect $zero,joint=1,offset_deg=0.5 --test A --direction +1 --centre programmed");
  const double e_um = 2.0 * std::hypot(380e3, 320e3) * std::sin(0.25 * std::numbers::pi / 180.0);
  EXPECT_NEAR(amplitude(eccentric[0], 2), e_um * e_um / 4.0 / 100e3, 0.1) << "e^2/4R";
  EXPECT_LT(eccentric[0]["ovality_um"].get<double>(), 0.001);
}

}  // namespace
}  // namespace ballbar

#pragma once
/// The tool as its users see it: real processes on the shipped recording, in a folder of their own.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar::test {

using Words = std::vector<std::string>;

inline const std::string kScripts = BALLBAR_SOURCE_DIR "/scripts";
inline const std::string kDemo = kScripts + "/demo.lcm";

inline Outcome ballbar(const Words& words) {
  Words all{kBallbar};
  all.insert(all.end(), words.begin(), words.end());
  return run(all);
}

/// A folder with a configuration for `robot` and an empty rules.d, and the shipped recording in a.db.
class ToolTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir = std::make_unique<TempDir>();
    std::filesystem::create_directory(dir->path() + "/rules.d");
    for (const std::string rule : {"/ovality_drift.lua", "/ovality_high.lua", "/straightness_high.lua"})
      std::filesystem::copy(kScripts + "/rules" + rule, dir->path() + "/rules.d" + rule);
    write_config("lrmate.toml", "lrmate-1");
    replayed = ballbar({"replay", kDemo, "--config", path("lrmate.toml"), "--db", path("a.db")});
    exported = nlohmann::json::parse(ballbar({"export", "--json", "--db", path("a.db")}).out);
  }
  static void TearDownTestSuite() { dir.reset(); }

  static std::string path(const std::string& name) { return dir->path() + "/" + name; }
  static void write_config(const std::string& name, const std::string& robot) {
    std::string text = read_file(kScripts + "/robots/lrmate200ic.toml");
    const auto replace = [&text](const std::string& from, const std::string& to) {
      text.replace(text.find(from), from.size(), to);
    };
    replace("\"lrmate200ic.urdf\"", "\"" + kScripts + "/robots/lrmate200ic.urdf\"");
    replace("\"lrmate-1\"", "\"" + robot + "\"");
    write_file(path(name), "[store]\npath = \"configured.db\"\n[rules]\ndirectory = \"rules.d\"\n" + text);
  }
  static nlohmann::json show(const std::string& run) {
    const Outcome outcome = ballbar({"show", run, "--json", "--db", path("a.db")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.code == 0 ? nlohmann::json::parse(outcome.out) : nlohmann::json();
  }
  static nlohmann::json first_of_kind(const std::string& kind) {
    for (const nlohmann::json& run : exported["runs"])
      if (run["kind"] == kind) return run;
    return {};
  }
  /// An exit code, nothing on standard output, and one line on standard error that says what is wrong.
  static void expect_error(const Words& words, int code, const std::string& says) {
    const Outcome outcome = ballbar(words);
    std::string command = "ballbar";
    for (const std::string& word : words) command += " " + word;
    SCOPED_TRACE(command + "\n" + outcome.err);
    EXPECT_EQ(outcome.code, code);
    EXPECT_EQ(outcome.out, "");
    EXPECT_TRUE(outcome.err.starts_with("ballbar: "));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << "an error is one line";
    EXPECT_NE(outcome.err.find(says), std::string::npos) << "does not say: " << says;
  }

  static inline std::unique_ptr<TempDir> dir;
  static inline Outcome replayed;
  static inline nlohmann::json exported;
};

}  // namespace ballbar::test

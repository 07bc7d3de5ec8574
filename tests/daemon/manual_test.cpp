// Manual pages and completion hold what the programs themselves say.

#include <iterator>
#include <sstream>

#include "support/tool_test.hpp"

namespace ballbar {
namespace {

using test::Words;

/// "-o,--output TEXT" and "check" at the begin of a line of help, by its headings.
struct Help {
  std::vector<std::string> verbs, options;
};

Help help(Words words) {
  words.push_back("--help");
  const test::Outcome outcome = test::run(words);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  Help found;
  std::istringstream text(outcome.out);
  std::string part;
  for (std::string line; std::getline(text, line);) {
    if (!line.empty() && line[0] != ' ') part = line;
    if (!line.starts_with("  ") || line.size() < 3 || line[2] == ' ') continue;
    const std::string first = line.substr(2, line.find(' ', 2) - 2);
    if (part == "Subcommands:") found.verbs.push_back(first);
    if (part == "Options:") found.options.push_back(first.substr(first.find("--")));
  }
  return found;
}

/// The part of ballbar(1) under this verb's headline.
std::string section(const std::string& page, const std::string& name) {
  const std::string head = name.empty() ? ".SH OPTIONS\n" : ".SS \"" + name + "\"\n";
  const std::size_t begin = page.find(head);
  if (begin == std::string::npos) return "";
  return page.substr(begin, page.find("\n.S", begin + 1) - begin);
}

std::string as_roff(std::string text) {
  for (std::size_t at = 0; (at = text.find('-', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

std::vector<std::string> completed(const std::string& typed) {
  const std::string script =
      "source <(" + test::kBallbar + " --bash-completion); COMP_WORDS=(" + typed +
      " ''); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _ballbar; echo \"${COMPREPLY[*]}\"";
  std::istringstream words(test::run({"bash", "-c", script}).out);
  return {std::istream_iterator<std::string>(words), {}};
}

void expect_in_manual(const std::string& page, const Words& words, int& options) {
  std::string name;
  Words command{test::kBallbar};
  for (const std::string& word : words) {
    name += (name.empty() ? "" : " ") + word;
    command.push_back(word);
  }
  SCOPED_TRACE(name);
  const Help said = help(command);
  const std::string text = section(page, name);
  const std::vector<std::string> offered = completed("ballbar " + name);
  const auto offers = [&](const std::string& word) {
    return std::find(offered.begin(), offered.end(), word) != offered.end();
  };
  EXPECT_FALSE(text.empty()) << "no section";
  for (const std::string& option : said.options) {
    EXPECT_NE(text.find(as_roff(option)), std::string::npos) << option << " is not in the manual";
    EXPECT_TRUE(offers(option)) << option << " is not completed";
    ++options;
  }
  for (const std::string& verb : said.verbs) {
    EXPECT_TRUE(offers(verb)) << verb << " is not completed";
    Words deeper = words;
    deeper.push_back(verb);
    expect_in_manual(page, deeper, options);
  }
}

TEST(Manual, HoldsEveryVerbAndOptionOfTheTool) {
  const std::string page = test::run({test::kBallbar, "--man-page"}).out;
  int options = 0;
  expect_in_manual(page, {}, options);
  EXPECT_GT(options, 80);
}

TEST(Manual, CompletionKnowsTheWordsOfAnOption) {
  const std::vector<std::string> kinds = completed("ballbar plot --kind");
  EXPECT_NE(std::find(kinds.begin(), kinds.end(), "trend"), kinds.end());
}

TEST(Manual, HoldsEveryOptionOfTheService) {
  const std::string page = test::read_file(BALLBAR_SOURCE_DIR "/docs/man/ballbard.8.md");
  for (const std::string& option : help({test::kBallbard}).options)
    EXPECT_NE(page.find("**" + option + "**"), std::string::npos) << option;
}

/// An unknown key makes the program itself name those that it knows.
TEST(Manual, HoldsEveryKeyOfTheConfiguration) {
  const std::string page = test::read_file(BALLBAR_SOURCE_DIR "/docs/man/ballbard.toml.5.md");
  const test::TempDir dir;
  const std::string file = dir.path() + "/c.toml";
  const std::string robot = "[[robot]]\nname = \"r\"\nurdf = \"" + test::kScripts + "/robots/ur10.urdf\"\n";
  const std::string circle =
      "[[robot.test]]\nname = \"A\"\nkind = \"circle\"\ncentre_mm = [1, 2, 3]\nradius_mm = 100\n";
  const std::string line =
      "[[robot.test]]\nname = \"Y\"\nkind = \"line\"\nstart_mm = [0, 0, 0]\nend_mm = [1, 2, 3]\n";
  int keys = 0;
  for (const std::string& part : {std::string("[bus]\n"), std::string("[store]\n"), std::string("[rules]\n"),
                                  std::string("[metrics]\n"), robot, robot + circle, robot + line}) {
    test::write_file(file, part + "no_such_key = 1\n");
    const std::string said = test::ballbar({"config", "check", file}).err;
    const std::string known = "known are: ";
    ASSERT_NE(said.find(known), std::string::npos) << said;
    std::string names = said.substr(said.find(known) + known.size());
    std::replace(names.begin(), names.end(), ',', ' ');
    std::istringstream words(names);
    for (std::string key; words >> key; ++keys)
      EXPECT_NE(page.find(key), std::string::npos) << key << " of " << part;
  }
  EXPECT_GT(keys, 30);
}

}  // namespace
}  // namespace ballbar

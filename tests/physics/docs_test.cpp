// docs/effects.md is true: its tables hold the catalogue, row by row and nothing else.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <sstream>

#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

std::string shown(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

std::string joint_column(JointUse use) {
  switch (use) {
    case JointUse::kNone:
      return "";
    case JointUse::kOne:
      return "yes";
    case JointUse::kOneOrAll:
      return "yes, 0 = all";
    case JointUse::kLinkOrAll:
      return "link, 0 = all";
  }
  return "?";
}

std::string need_column(Need need) {
  switch (need) {
    case Need::kRequired:
      return "yes";
    case Need::kOptional:
      return "";
    case Need::kSomeOf:
      return "any of these";
    case Need::kOneOf:
      return "one of these";
  }
  return "?";
}

std::string effect_rows() {
  std::string text = "| effect | joint | what it is | source |\n|---|---|---|---|\n";
  for (const EffectKind& kind : effect_catalogue())
    text += "| `" + std::string(kind.name) + "` | " + joint_column(kind.joint) + " | " +
            std::string(kind.meaning) + " | " + std::string(kind.source) + " |\n";
  return text;
}

std::string parameter_rows() {
  std::string text = "| effect | parameter | needed | typical | what it is |\n|---|---|---|---|---|\n";
  for (const EffectKind& kind : effect_catalogue()) {
    for (const ParameterKind& p : kind.parameters)
      text += "| `" + std::string(kind.name) + "` | `" + std::string(p.name) + "` | " + need_column(p.need) +
              " | " + (p.typical == 0.0 ? "" : shown(p.typical)) + " | " + std::string(p.meaning) + " |\n";
    if (kind.word.name.empty()) continue;
    text += "| `" + std::string(kind.name) + "` | `" + std::string(kind.word.name) + "` | " +
            (kind.word.required ? "yes" : "") + " | |";
    for (const std::string_view word : kind.word.allowed)
      text += (word == kind.word.allowed.front() ? " `\"" : ", `\"") + std::string(word) + "\"`";
    text += " |\n";
  }
  return text;
}

TEST(EffectsDocument, HoldsTheCatalogue) {
  std::ifstream file(BALLBAR_SOURCE_DIR "/docs/effects.md");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  for (const std::string& table : {effect_rows(), parameter_rows()})
    EXPECT_NE(text.find("\n\n" + table + "\n"), std::string::npos) << "the table should be\n" << table;
}

}  // namespace
}  // namespace ballbar

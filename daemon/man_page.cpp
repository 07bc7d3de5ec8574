#include "daemon/man_page.hpp"

#include <algorithm>
#include <vector>

namespace ballbar {
namespace {

/// Text as roff prints it: no escapes, no requests, hyphens as they are typed.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
      out += std::string("\\&") + c;
    else
      out += c;
  }
  return out;
}

std::vector<const CLI::App*> verbs_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* verb) { return !verb->get_name().empty(); });
}

std::string value_of(const CLI::Option& option) {
  if (option.get_type_size() == 0) return "";
  const std::string type = option.get_type_name();
  std::string text = type.substr(0, type.find(':'));
  if (const std::size_t words = type.find('{'); words != std::string::npos) text = type.substr(words);
  return text.empty() ? "VALUE" : text;
}

std::string about(const CLI::Option& option) {
  std::string text = option.get_description();
  if (!option.get_default_str().empty()) text += " (default: " + option.get_default_str() + ")";
  if (option.get_required()) text += "; needed";
  return text;
}

void add_options(const CLI::App& app, std::string& page) {
  for (const CLI::Option* option : app.get_options()) {
    page += ".TP\n";
    if (option->nonpositional()) {
      std::string names;
      for (const std::string& name : option->get_snames()) names += (names.empty() ? "-" : ", -") + name;
      for (const std::string& name : option->get_lnames()) names += (names.empty() ? "--" : ", --") + name;
      page += "\\fB" + roff(names) + "\\fR";
      if (const std::string value = value_of(*option); !value.empty()) page += " " + roff(value);
    } else {
      page += "\\fI" + roff(option->get_name(true)) + "\\fR";
    }
    page += "\n" + roff(about(*option)) + "\n";
  }
}

void add_verb(const CLI::App& verb, const std::string& parents, std::string& page) {
  const std::string name = parents + verb.get_name();
  page += ".SS \"" + roff(name) + "\"\n" + roff(verb.get_description()) + "\n";
  add_options(verb, page);
  for (const CLI::App* sub : verbs_of(verb)) add_verb(*sub, name + " ", page);
}

/// "--kind": after this word come these words.
void add_words(const CLI::App& app, std::string& cases) {
  for (const CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name();
    const std::size_t begin = type.find('{');
    if (!option->nonpositional() || begin == std::string::npos) continue;
    std::string words = type.substr(begin + 1, type.find('}') - begin - 1);
    std::replace(words.begin(), words.end(), ',', ' ');
    cases +=
        "    \"" + app.get_name() + " --" + option->get_lnames().front() + "\") words='" + words + "' ;;\n";
  }
}

void add_choices(const CLI::App& app, const std::string& key, std::string& cases, std::string& words) {
  std::string choices;
  for (const CLI::App* verb : verbs_of(app)) choices += verb->get_name() + " ";
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) choices += "--" + name + " ";
  if (!choices.empty()) choices.pop_back();
  cases += "    \"" + key + "\") words='" + choices + "' ;;\n";
  add_words(app, words);
  for (const CLI::App* verb : verbs_of(app))
    add_choices(*verb, key.empty() ? verb->get_name() : key + " " + verb->get_name(), cases, words);
}

/// Verbs that have verbs of their own.
std::string parents_of(const CLI::App& app) {
  std::string names;
  for (const CLI::App* verb : verbs_of(app))
    if (!verbs_of(*verb).empty()) names += (names.empty() ? "" : " | ") + verb->get_name();
  return names;
}

}  // namespace

std::string man_page(const CLI::App& app, const std::string& version, const std::string& more) {
  std::string upper = app.get_name();
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string page = ".TH " + upper + " 1 \"\" \"ballbard " + version + "\" \"User commands\"\n";
  page += ".SH NAME\n" + roff(app.get_name()) + " \\- ballbar and straightness measurements of robots\n";
  page += ".SH SYNOPSIS\n\\fB" + roff(app.get_name()) + "\\fR \\fIVERB\\fR [\\fIOPTION\\fR...]\n";
  page += ".SH DESCRIPTION\n" + roff(app.get_description()) + "\n.SH OPTIONS\n";
  add_options(app, page);
  page += ".SH VERBS\n";
  for (const CLI::App* verb : verbs_of(app)) add_verb(*verb, "", page);
  return page + ".SH \"EXIT STATUS\"\n" + roff(app.get_footer()) + "\n" + more;
}

std::string bash_completion(const CLI::App& app) {
  std::string choices, words;
  add_choices(app, "", choices, words);
  return "# bash completion of " + app.get_name() +
         R"(. Made from the program's own command line.
_ballbar() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} verb='' verbs='' words=''
  [ "$COMP_CWORD" -gt 1 ] && verb=${COMP_WORDS[1]} verbs=${COMP_WORDS[1]}
  case $verb in
    )" + parents_of(app) +
         R"() [ "$COMP_CWORD" -gt 2 ] && verb=${COMP_WORDS[2]} verbs="$verbs ${COMP_WORDS[2]}" ;;
  esac
  case "$verb $before" in
)" + words +
         R"(  esac
  if [ -z "$words" ]; then
    case "$verbs" in
)" + choices +
         R"(    esac
  fi
  COMPREPLY=($(compgen -W "$words" -- "$word"))
}
complete -o default -F _ballbar )" +
         app.get_name() + "\n";
}

}  // namespace ballbar

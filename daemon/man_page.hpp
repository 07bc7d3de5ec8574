#pragma once
/// Manual page and completion of a command line, made from the command line itself.

#include <CLI/CLI.hpp>
#include <string>

namespace ballbar {

/// A page for man(1), with every verb and option.
/// @param more  further sections in roff, behind the verbs
std::string man_page(const CLI::App& app, const std::string& version, const std::string& more);

/// For bash: verbs, options, words that an option can have, files elsewhere.
std::string bash_completion(const CLI::App& app);

}  // namespace ballbar

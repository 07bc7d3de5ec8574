#pragma once
/// Rule files on disk.

#include <filesystem>
#include <vector>

#include "rules/rule.hpp"

namespace ballbar {

/// The rules of a folder, by name: *.lua without *_test.lua and hidden files.
/// @throws Error where the folder cannot be read
std::vector<std::filesystem::path> rule_files(const std::filesystem::path& directory);

/// The rules of several folders, by name. Of files with one name that in the last folder counts; where it is
/// empty, none does: so a person's own folder changes or switches off what is shipped.
/// @throws Error where a folder cannot be read
std::vector<std::filesystem::path> rule_files(const std::vector<std::filesystem::path>& directories);

/// The test tables of a folder, by name: *_test.lua without hidden files.
/// @throws Error where the folder cannot be read
std::vector<std::filesystem::path> rule_test_files(const std::filesystem::path& directory);

/// @throws Error where the file cannot be read, is no plain file, or is longer than kMaxRuleBytes
RuleSource read_rule_file(const std::filesystem::path& path);

}  // namespace ballbar

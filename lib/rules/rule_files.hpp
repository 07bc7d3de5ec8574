#pragma once
/// Rule files on disk.

#include <filesystem>
#include <vector>

#include "rules/rule.hpp"

namespace ballbar {

/// The rules of a folder, by name: *.lua without *_test.lua and hidden files.
/// @throws Error where the folder cannot be read
std::vector<std::filesystem::path> rule_files(const std::filesystem::path& directory);

/// The test tables of a folder, by name: *_test.lua without hidden files.
/// @throws Error where the folder cannot be read
std::vector<std::filesystem::path> rule_test_files(const std::filesystem::path& directory);

/// @throws Error where the file cannot be read, is no plain file, or is longer than kMaxRuleBytes
RuleSource read_rule_file(const std::filesystem::path& path);

}  // namespace ballbar

#include "rules/rule_files.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <system_error>

#include "core/error.hpp"

namespace ballbar {
namespace {

std::vector<std::filesystem::path> lua_files(const std::filesystem::path& directory, bool tests) {
  std::error_code failure;
  std::vector<std::filesystem::path> found;
  std::filesystem::directory_iterator it(directory, failure);
  for (; !failure && it != std::filesystem::directory_iterator(); it.increment(failure)) {
    const std::string name = it->path().filename().string();
    if (!name.ends_with(".lua") || name.front() == '.' || name.ends_with("_test.lua") != tests) continue;
    found.push_back(it->path());
  }
  if (failure) {
    throw Error(Cause::kInput, "rules: cannot read the folder " + directory.string() + ": " +
                                   failure.message() + "; create it, or set [rules] directory");
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

std::vector<std::filesystem::path> rule_files(const std::filesystem::path& directory) {
  return lua_files(directory, false);
}

std::vector<std::filesystem::path> rule_files(const std::vector<std::filesystem::path>& directories) {
  std::map<std::string, std::filesystem::path> by_name;
  for (const std::filesystem::path& directory : directories)
    for (const std::filesystem::path& path : rule_files(directory)) {
      const auto [entry, first] = by_name.insert_or_assign(path.filename().string(), path);
      std::error_code unreadable;
      if (!first && std::filesystem::is_regular_file(path, unreadable) &&
          std::filesystem::file_size(path, unreadable) == 0)
        by_name.erase(entry);
    }
  std::vector<std::filesystem::path> found;
  found.reserve(by_name.size());
  for (const auto& [name, path] : by_name) found.push_back(path);
  return found;
}

std::vector<std::filesystem::path> rule_test_files(const std::filesystem::path& directory) {
  return lua_files(directory, true);
}

RuleSource read_rule_file(const std::filesystem::path& path) {
  // Asked before opening: opening a pipe would wait for a writer.
  std::error_code failure;
  if (!std::filesystem::is_regular_file(path, failure))
    throw Error(Cause::kInput, "not a file that can be read" + (failure ? ": " + failure.message() : ""));
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxRuleBytes + 1, '\0');
  if (!file || !file.read(text.data(), static_cast<std::streamsize>(text.size())).eof()) {
    throw Error(Cause::kInput,
                file ? "the file is longer than 64 KiB" : "cannot be read; is it readable for the service?");
  }
  text.resize(static_cast<std::size_t>(file.gcount()));
  return {path.filename().string(), std::move(text)};
}

}  // namespace ballbar

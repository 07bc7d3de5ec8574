#include "store/set_aside.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace ballbar {

namespace fs = std::filesystem;

namespace {

bool is_damage(const StoreError& error, const std::string& path) {
  std::error_code ignored;
  return error.kind() == StoreFault::kCorrupt ||
         (error.kind() == StoreFault::kNotADatabase && fs::exists(path + "-wal", ignored));
}

}  // namespace

std::string set_aside(const std::string& path, const std::string& word) {
  int number = 1;
  std::string to;
  do to = path + "." + word + "-" + std::to_string(number++);
  while (fs::exists(to));
  // What the WAL holds belongs to this file: left behind, it would be taken for part of the next one.
  for (const std::string part : {"", "-wal", "-shm"}) {
    std::error_code error;
    fs::rename(path + part, to + part, error);
    if (error && (part.empty() || error != std::errc::no_such_file_or_directory))
      throw StoreError(StoreFault::kReadOnly, path + part + ": cannot be renamed to set it aside: " +
                                                  error.message() + "; check permissions of the folder");
  }
  return to;
}

std::vector<std::string> set_aside_before(const std::string& path) {
  const fs::path file(path);
  const std::string begin = file.filename().string() + ".damaged-";
  std::vector<std::string> found;
  std::error_code error;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(begin) && name.find_first_not_of("0123456789", begin.size()) == std::string::npos)
      found.push_back((folder / name).string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

OpenedStore open_or_set_aside(const std::string& path, const StoreOptions& options) {
  std::string damage;
  try {
    return {Store(path, options), "", ""};
  } catch (const StoreError& error) {
    if (!is_damage(error, path)) throw;
    damage = error.what();
  }
  const std::string to = set_aside(path);
  return {Store(path, options), to, damage};
}

}  // namespace ballbar

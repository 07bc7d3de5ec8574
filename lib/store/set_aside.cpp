#include "store/set_aside.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace ballbar {

namespace fs = std::filesystem;

namespace {

constexpr const char* kMark = ".damaged-";

bool is_damage(const StoreError& error, const std::string& path) {
  std::error_code ignored;
  return error.kind() == StoreFault::kCorrupt ||
         (error.kind() == StoreFault::kNotADatabase && fs::exists(path + "-wal", ignored));
}

}  // namespace

std::string set_aside(const std::string& path) {
  int number = 1;
  while (fs::exists(path + kMark + std::to_string(number))) ++number;
  std::string to = path + kMark + std::to_string(number);
  std::error_code error;
  fs::rename(path, to, error);
  if (error)
    throw StoreError(StoreFault::kReadOnly, path + ": is damaged and cannot be set aside: " +
                                                error.message() + "; move the file away to begin a new one");
  // What the WAL holds belongs to the damaged file. Where one is missing there is nothing to keep.
  for (const char* part : {"-wal", "-shm"}) {
    std::error_code ignored;
    fs::rename(path + part, to + part, ignored);
  }
  return to;
}

std::vector<std::string> set_aside_before(const std::string& path) {
  const fs::path file(path);
  const std::string begin = file.filename().string() + kMark;
  std::vector<std::string> found;
  std::error_code error;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(begin) && !name.ends_with("-wal") && !name.ends_with("-shm"))
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

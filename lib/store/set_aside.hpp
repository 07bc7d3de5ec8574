#pragma once
/// A damaged database makes room for a new one, and is kept for `ballbar db recover`.

#include <string>
#include <vector>

#include "store/store.hpp"

namespace ballbar {

/// Renames PATH and its -wal and -shm to PATH.WORD-1 and so on, the first number that is free. No
/// connection of this process may go on writing to it.
/// @return the new name
/// @throws StoreError(kReadOnly) where the folder does not allow it
std::string set_aside(const std::string& path, const std::string& word = "damaged");

/// Databases that were set aside beside `path` as damaged and are still there, by name.
std::vector<std::string> set_aside_before(const std::string& path);

struct OpenedStore {
  Store store;
  std::string set_aside;  ///< where the damaged one lies now; empty: it was sound
  std::string damage;     ///< what was wrong with it
};

/// As Store(path), but a damaged database of ours is set aside and a new one begun. A file that is no
/// database at all counts as ours where a WAL lies beside it; else the path is wrong, and it is left as it
/// is.
/// @throws StoreError as Store()
OpenedStore open_or_set_aside(const std::string& path, const StoreOptions& options = {});

}  // namespace ballbar

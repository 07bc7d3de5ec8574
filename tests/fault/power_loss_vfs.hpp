#pragma once
/// A disk that remembers in which sequence it was written to and synced, so that a power cut can be made up
/// after any of its writes: what was not yet synced is lost, there, torn, or any mixture of these.

#include <sqlite3.h>

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace ballbar::test {

struct DiskOperation {
  enum class Kind { kWrite, kTruncate, kSync, kDelete, kAcknowledged };
  Kind kind = Kind::kWrite;
  std::string file;         ///< name without folder
  std::int64_t offset = 0;  ///< or the size after a truncation, or the run that was acknowledged
  std::string bytes;
};

/// What a power cut leaves of the writes that were not yet synced.
enum class Unsynced { kLost, kThere, kSome, kTorn };

using Image = std::map<std::string, std::string>;  ///< files by name

class RecordedDisk {
 public:
  /// Becomes SQLite's disk for what is opened from now on.
  RecordedDisk();
  ~RecordedDisk();  ///< all that was opened through it must be closed
  RecordedDisk(const RecordedDisk&) = delete;
  RecordedDisk& operator=(const RecordedDisk&) = delete;

  void acknowledge(std::int64_t run) { log.push_back({DiskOperation::Kind::kAcknowledged, "", run, ""}); }

  std::vector<DiskOperation> log;
};

namespace power_loss {

constexpr std::size_t kSector = 512;

inline RecordedDisk* disk = nullptr;

struct File {
  sqlite3_file base;
  const char* name;
  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

inline File* file_of(sqlite3_file* file) { return reinterpret_cast<File*>(file); }
inline sqlite3_file* real_of(sqlite3_file* file) { return file_of(file)->real(); }

inline void note(sqlite3_file* file, DiskOperation::Kind kind, std::int64_t offset, std::string bytes) {
  const std::string path = file_of(file)->name ? file_of(file)->name : "";
  if (!path.empty()) disk->log.push_back({kind, path.substr(path.rfind('/') + 1), offset, std::move(bytes)});
}

inline int write(sqlite3_file* f, const void* data, int size, sqlite3_int64 offset) {
  note(f, DiskOperation::Kind::kWrite, offset,
       std::string(static_cast<const char*>(data), static_cast<std::size_t>(size)));
  return real_of(f)->pMethods->xWrite(real_of(f), data, size, offset);
}
inline int truncate(sqlite3_file* f, sqlite3_int64 size) {
  note(f, DiskOperation::Kind::kTruncate, size, "");
  return real_of(f)->pMethods->xTruncate(real_of(f), size);
}
inline int sync(sqlite3_file* f, int) {
  note(f, DiskOperation::Kind::kSync, 0, "");
  return SQLITE_OK;  // the test's own disk loses nothing
}

/// The rest goes through as it is.
inline const sqlite3_io_methods& methods() {
  static const sqlite3_io_methods m = [] {
    sqlite3_io_methods io{};
    io.iVersion = 2;
    io.xClose = [](sqlite3_file* f) { return real_of(f)->pMethods->xClose(real_of(f)); };
    io.xRead = [](sqlite3_file* f, void* to, int n, sqlite3_int64 at) {
      return real_of(f)->pMethods->xRead(real_of(f), to, n, at);
    };
    io.xWrite = write;
    io.xTruncate = truncate;
    io.xSync = sync;
    io.xFileSize = [](sqlite3_file* f, sqlite3_int64* n) {
      return real_of(f)->pMethods->xFileSize(real_of(f), n);
    };
    io.xLock = [](sqlite3_file* f, int lock) { return real_of(f)->pMethods->xLock(real_of(f), lock); };
    io.xUnlock = [](sqlite3_file* f, int lock) { return real_of(f)->pMethods->xUnlock(real_of(f), lock); };
    io.xCheckReservedLock = [](sqlite3_file* f, int* out) {
      return real_of(f)->pMethods->xCheckReservedLock(real_of(f), out);
    };
    io.xFileControl = [](sqlite3_file* f, int op, void* arg) {
      return real_of(f)->pMethods->xFileControl(real_of(f), op, arg);
    };
    io.xSectorSize = [](sqlite3_file* f) { return real_of(f)->pMethods->xSectorSize(real_of(f)); };
    io.xDeviceCharacteristics = [](sqlite3_file* f) {
      return real_of(f)->pMethods->xDeviceCharacteristics(real_of(f));
    };
    io.xShmMap = [](sqlite3_file* f, int page, int size, int extend, void volatile** out) {
      return real_of(f)->pMethods->xShmMap(real_of(f), page, size, extend, out);
    };
    io.xShmLock = [](sqlite3_file* f, int from, int n, int flags) {
      return real_of(f)->pMethods->xShmLock(real_of(f), from, n, flags);
    };
    io.xShmBarrier = [](sqlite3_file* f) { real_of(f)->pMethods->xShmBarrier(real_of(f)); };
    io.xShmUnmap = [](sqlite3_file* f, int remove) {
      return real_of(f)->pMethods->xShmUnmap(real_of(f), remove);
    };
    return io;
  }();
  return m;
}

inline sqlite3_vfs* real_vfs() { return sqlite3_vfs_find("unix"); }

inline sqlite3_vfs& vfs() {
  static sqlite3_vfs v = [] {
    sqlite3_vfs made = *real_vfs();
    made.zName = "power-loss";
    made.pNext = nullptr;
    made.szOsFile = static_cast<int>(sizeof(File)) + real_vfs()->szOsFile;
    made.xOpen = [](sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out) {
      file_of(file)->name = name;
      const int code = real_vfs()->xOpen(real_vfs(), name, real_of(file), flags, out);
      file->pMethods = code == SQLITE_OK ? &methods() : nullptr;
      return code;
    };
    made.xDelete = [](sqlite3_vfs*, const char* name, int sync_folder) {
      const std::string path = name;
      disk->log.push_back({DiskOperation::Kind::kDelete, path.substr(path.rfind('/') + 1), 0, ""});
      return real_vfs()->xDelete(real_vfs(), name, sync_folder);
    };
    return made;
  }();
  return v;
}

inline void put(std::string& file, std::size_t offset, std::string_view bytes) {
  if (file.size() < offset + bytes.size()) file.resize(offset + bytes.size(), '\0');
  file.replace(offset, bytes.size(), bytes);
}

/// One write or truncation onto one file; of a torn write any of its sectors.
inline void apply(std::string& file, const DiskOperation& operation, bool torn, std::mt19937_64& rng) {
  const auto offset = static_cast<std::size_t>(operation.offset);
  if (operation.kind == DiskOperation::Kind::kTruncate) {
    if (!torn || rng() % 2 == 0) file.resize(offset, '\0');
    return;
  }
  if (!torn) return put(file, offset, operation.bytes);
  const std::string_view bytes = operation.bytes;
  for (std::size_t from = 0; from < bytes.size();) {
    const std::size_t length = std::min(kSector - (offset + from) % kSector, bytes.size() - from);
    if (rng() % 2 == 0) put(file, offset + from, bytes.substr(from, length));
    from += length;
  }
}

}  // namespace power_loss

inline RecordedDisk::RecordedDisk() {
  power_loss::disk = this;
  sqlite3_vfs_register(&power_loss::vfs(), 1);
}

inline RecordedDisk::~RecordedDisk() {
  sqlite3_vfs_unregister(&power_loss::vfs());
  sqlite3_vfs_register(power_loss::real_vfs(), 1);
  power_loss::disk = nullptr;
}

/// What stands on the disk after a power cut behind the first `count` operations. That a file was made or
/// deleted is taken as lasting.
inline Image after_power_cut(const std::vector<DiskOperation>& log, std::size_t count, Unsynced unsynced,
                             std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  Image image;
  std::map<std::string, std::vector<const DiskOperation*>> pending;
  const auto flush = [&](const std::string& file, Unsynced how) {
    for (const DiskOperation* operation : pending[file]) {
      const bool kept =
          how == Unsynced::kThere || how == Unsynced::kTorn || (how == Unsynced::kSome && rng() % 2 == 0);
      if (kept) power_loss::apply(image[file], *operation, how == Unsynced::kTorn, rng);
    }
    pending[file].clear();
  };
  for (std::size_t i = 0; i < count; ++i) {
    const DiskOperation& operation = log[i];
    switch (operation.kind) {
      case DiskOperation::Kind::kWrite:
      case DiskOperation::Kind::kTruncate:
        image.try_emplace(operation.file);
        pending[operation.file].push_back(&operation);
        break;
      case DiskOperation::Kind::kSync:
        flush(operation.file, Unsynced::kThere);
        break;
      case DiskOperation::Kind::kDelete:
        image.erase(operation.file);
        pending.erase(operation.file);
        break;
      case DiskOperation::Kind::kAcknowledged:
        break;
    }
  }
  std::vector<std::string> files;
  for (const auto& [file, operations] : pending) files.push_back(file);
  for (const std::string& file : files) flush(file, unsynced);
  return image;
}

}  // namespace ballbar::test

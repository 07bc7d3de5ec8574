#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>

#include "store/migrations.hpp"
#include "store/schema.hpp"
#include "store/store.hpp"

namespace ballbar {

namespace {

constexpr ::mode_t kFileMode = 0640;  // -wal and -shm take it over from the database

int newest_version() { return static_cast<int>(schema_steps().size()); }

void check_folder(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::error_code ignored;
  if (folder.empty() || std::filesystem::is_directory(folder, ignored)) return;
  throw StoreError(StoreFault::kCannotOpen,
                   path + ": there is no folder " + folder.string() + "; create it, or set [store] path");
}

/// Only where there is no file yet: to close a file that SQLite has open would drop its locks.
void make_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, kFileMode);
  if (fd < 0) return;       // there already, or SQLite will say why not
  ::fchmod(fd, kFileMode);  // whatever the umask: the group may read
  ::close(fd);
}

/// All but the recordings, to stay quick with years of them; each of those has its own checksum.
void quick_check(Database& db) {
  Statement tables(db, "SELECT name FROM sqlite_schema WHERE type = 'table' AND name <> 'trace'");
  while (tables.step()) {
    Statement check(db, "PRAGMA quick_check(" + tables.text(0) + ")");
    if (check.step() && check.text(0) == "ok") continue;
    std::string what = check.text(0);
    std::replace(what.begin(), what.end(), '\n', ' ');
    throw StoreError(StoreFault::kCorrupt,
                     db.path() + ": the database is damaged: " + what +
                         "; restore a backup, or move the file away to begin a new one");
  }
}

}  // namespace

Store::Store(const std::string& path, const StoreOptions& options) {
  check_folder(path);
  make_file(path);
  db_ = std::make_unique<Database>(path, Database::Mode::kReadWrite, options.busy_timeout_ms);
  db_->set_checkpoint_on_close(false);  // until we know that it is ours
  const Identity identity = identify(*db_, newest_version());
  if (db_->is_read_only())
    throw StoreError(StoreFault::kReadOnly,
                     path + ": no right to write; check owner and permissions of file and folder");
  {
    Statement wal(*db_, "PRAGMA journal_mode = WAL");
    if (!wal.step() || wal.text(0) != "wal")
      throw StoreError(StoreFault::kOther,
                       path + ": this file system has no shared memory for WAL; choose a local disk");
  }
  db_->keep_wal_files();
  db_->execute("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON; PRAGMA journal_size_limit = 4194304");
  if (identity == Identity::kOurs) quick_check(*db_);
  migrate(*db_, schema_steps());
  refresh_views(*db_);
  db_->set_checkpoint_on_close(true);
}

Store Store::open_read_only(const std::string& path, const StoreOptions& options) {
  std::error_code unreadable;
  if (!std::filesystem::exists(path, unreadable) && !unreadable)
    throw StoreError(
        StoreFault::kCannotOpen,
        path + ": there is no such database; start ballbard or `ballbar replay` to make it, or give --db");
  auto db = std::make_unique<Database>(path, Database::Mode::kReadOnly, options.busy_timeout_ms);
  if (identify(*db, newest_version()) == Identity::kEmpty ||
      db->integer("PRAGMA user_version") < newest_version())
    throw StoreError(
        StoreFault::kOlder,
        path + ": empty, or written by an older version; start ballbard once to bring it up to date");
  return Store(std::move(db));
}

bool Store::checkpoint() {
  struct Impatient {
    explicit Impatient(Database& of) : db(of), patience_ms(of.busy_timeout()) { db.set_busy_timeout(0); }
    ~Impatient() { db.set_busy_timeout(patience_ms); }
    Database& db;
    int patience_ms;
  };
  const Impatient impatient(*db_);
  Statement truncate(*db_, "PRAGMA wal_checkpoint(TRUNCATE)");
  return truncate.step() && truncate.integer(0) == 0;
}

}  // namespace ballbar

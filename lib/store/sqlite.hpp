#pragma once
/// SQLite behind one door: connection, statement, transaction. Failures are StoreErrors that say what to do.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace ballbar {

/// What failed, so that a caller can choose: wait (kFull, kLocked), set the file aside (kCorrupt), or stop.
enum class StoreFault {
  kFull,     ///< no space; everything committed stays readable, and writing works again when there is space
  kLocked,   ///< another connection holds the lock for longer than the busy timeout
  kCorrupt,  ///< the file is one of ours, but damaged
  kNotADatabase,  ///< no SQLite file, or its header is damaged
  kForeign,       ///< a database of another application; left as it is
  kNewer,         ///< written by a newer version; left as it is
  kOlder,         ///< read-only only: written by an older version, and nobody may bring it up to date
  kReadOnly,      ///< no right to write
  kCannotOpen,    ///< folder or file missing, or no right to read
  kDuplicate,     ///< a run of this robot and begin is stored already
  kNotFound,      ///< no run of this id
  kOther,
};

/// One line: path, what, and what to do.
class StoreError : public Error {
 public:
  StoreError(StoreFault kind, const std::string& what) : Error(Cause::kWorld, what), kind_(kind) {}
  StoreFault kind() const { return kind_; }

 private:
  StoreFault kind_;
};

/// One connection. Not for use by two threads at once.
class Database {
 public:
  enum class Mode { kReadWrite, kReadOnly };

  /// @param path  a file name, never a URI. kReadWrite makes the file where it is missing, but no folder
  /// @throws StoreError
  Database(const std::string& path, Mode mode, int busy_timeout_ms);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Runs one or more statements and drops their rows. @throws StoreError
  void execute(const std::string& sql);

  /// First column of the first row; 0 where there is no row. @throws StoreError
  std::int64_t integer(std::string_view sql);

  /// Keeps -wal and -shm when the last connection closes: without them a user who may only read cannot open
  /// a WAL database.
  void keep_wal_files();

  /// Statements that wait for their next use hold the tables of attached databases.
  void forget_statements() { prepared_.clear(); }

  /// False: closing leaves the file's bytes alone, even where a WAL waits to be copied into it.
  void set_checkpoint_on_close(bool on);

  /// [ms] how long a write waits for another program's.
  void set_busy_timeout(int ms);
  int busy_timeout() const { return busy_timeout_ms_; }

  bool is_read_only() const;
  bool damaged() const { return damaged_; }  ///< SQLite met damage in this file, whoever asked for what
  const std::string& path() const { return path_; }

  /// @param code   of SQLite; the message is the connection's latest
  [[noreturn]] void fail(int code) const;

 private:
  friend class Statement;
  friend class Transaction;
  friend class Snapshot;
  struct Close {
    void operator()(sqlite3* db) const;
  };
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  using Prepared = std::unique_ptr<sqlite3_stmt, Finalize>;

  Prepared take(std::string_view sql);
  void give_back(std::string_view sql, Prepared statement);

  std::string path_;
  int busy_timeout_ms_;
  mutable bool damaged_ = false;
  std::unique_ptr<sqlite3, Close> db_;
  std::map<std::string, Prepared, std::less<>> prepared_;  // idle ones, by text; gone before db_ is
};

/// One use of a prepared statement. The text is compiled once per connection; the end of the use resets it:
/// no read transaction stays open.
class Statement {
 public:
  /// @throws StoreError
  Statement(Database& db, std::string_view sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  /// Binds ?1, ?2, ... and starts over.
  /// @throws std::invalid_argument for a number that is not finite: SQLite would store NULL
  template <class... Values>
  Statement& bind(const Values&... values) {
    rewind();
    int index = 0;
    (bind_one(++index, values), ...);
    return *this;
  }

  /// True: there is a row. @throws StoreError
  bool step();
  /// To the end. @throws StoreError
  void run() {
    while (step()) {
    }
  }

  // Columns of the row, from 0.
  std::int64_t integer(int column) const;
  int small(int column) const { return static_cast<int>(integer(column)); }
  double real(int column) const;
  std::optional<double> maybe_real(int column) const;
  std::optional<std::int64_t> maybe_integer(int column) const;
  std::string text(int column) const;
  std::vector<std::uint8_t> blob(int column) const;
  bool is_null(int column) const;

 private:
  void rewind();
  void check(int code) const;
  void bind_one(int index, std::int64_t value);
  void bind_one(int index, int value) { bind_one(index, static_cast<std::int64_t>(value)); }
  void bind_one(int index, double value);
  void bind_one(int index, std::string_view value);
  void bind_one(int index, const std::string& value) { bind_one(index, std::string_view(value)); }
  void bind_one(int index, const char* value) { bind_one(index, std::string_view(value)); }
  void bind_one(int index, const std::vector<std::uint8_t>& value);
  void bind_one(int index, std::nullopt_t);
  template <class Value>
  void bind_one(int index, const std::optional<Value>& value) {
    value ? bind_one(index, *value) : bind_one(index, std::nullopt);
  }

  Database& db_;
  std::string sql_;
  Database::Prepared statement_;
};

/// BEGIN IMMEDIATE ... COMMIT; whatever leaves the scope without commit() is rolled back.
class Transaction {
 public:
  /// @throws StoreError, kLocked where another writer does not end in time
  explicit Transaction(Database& db);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  /// @throws StoreError; then nothing is stored
  void commit();

 private:
  Database& db_;
  bool open_ = true;
};

/// One view of the data for several SELECTs: a deferred read transaction.
class Snapshot {
 public:
  explicit Snapshot(Database& db);
  ~Snapshot();
  Snapshot(const Snapshot&) = delete;
  Snapshot& operator=(const Snapshot&) = delete;

 private:
  Database& db_;
};

}  // namespace ballbar

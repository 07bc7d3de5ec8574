#include "store/sqlite.hpp"

#include <sqlite3.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace ballbar {

namespace {

struct Advice {
  StoreFault kind;
  const char* what_to_do;
};

Advice advice(int code) {
  switch (code & 0xff) {  // the primary code; the rest says more, but asks for nothing else
    case SQLITE_FULL:
      return {StoreFault::kFull, "free disk space, then try again"};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {StoreFault::kLocked, "another program holds the database: close it, then try again"};
    case SQLITE_CORRUPT:
      return {StoreFault::kCorrupt, "restore a backup, or move the file away to begin a new one"};
    case SQLITE_NOTADB:
      return {StoreFault::kNotADatabase, "check the path; the file was left as it is"};
    case SQLITE_READONLY:
      return {StoreFault::kReadOnly, "check owner and permissions of file and folder"};
    case SQLITE_CANTOPEN:
    case SQLITE_AUTH:
    case SQLITE_PERM:
      return {StoreFault::kCannotOpen, "check that the file is there and its permissions"};
    case SQLITE_IOERR:
      // The shared-memory file is the first to ask for space on a full disk.
      if (code == SQLITE_IOERR_SHMSIZE) return {StoreFault::kFull, "free disk space, then try again"};
      return {StoreFault::kOther, "check the disk"};
    default:
      return {StoreFault::kOther, "check the file with: ballbar db check"};
  }
}

}  // namespace

void Database::Close::operator()(sqlite3* db) const { sqlite3_close_v2(db); }
void Database::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Database::Database(const std::string& path, Mode mode, int busy_timeout_ms)
    : path_(path), busy_timeout_ms_(busy_timeout_ms) {
  // URIs are for ATTACH alone: this name is never one.
  const int flags = SQLITE_OPEN_URI | (mode == Mode::kReadOnly ? SQLITE_OPEN_READONLY
                                                               : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  // "./" keeps a name like ":memory:" or "file:x" a name.
  const std::string name = path.starts_with('/') ? path : "./" + path;
  sqlite3* db = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &db, flags, nullptr);
  db_.reset(db);
  if (db == nullptr) throw StoreError(StoreFault::kOther, path_ + ": no memory to open the database");
  sqlite3_extended_result_codes(db, 1);
  if (code != SQLITE_OK) fail(sqlite3_extended_errcode(db));
  sqlite3_busy_timeout(db, busy_timeout_ms);
}

Database::~Database() = default;

void Database::execute(const std::string& sql) {
  const int code = sqlite3_exec(db_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code);
}

std::int64_t Database::integer(std::string_view sql) {
  Statement query(*this, sql);
  return query.step() ? query.integer(0) : 0;
}

void Database::keep_wal_files() {
  int on = 1;
  const int code = sqlite3_file_control(db_.get(), "main", SQLITE_FCNTL_PERSIST_WAL, &on);
  if (code != SQLITE_OK) fail(code);
}

void Database::set_checkpoint_on_close(bool on) {
  sqlite3_db_config(db_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, on ? 0 : 1, nullptr);
}

void Database::set_busy_timeout(int ms) {
  sqlite3_busy_timeout(db_.get(), ms);
  busy_timeout_ms_ = ms;
}

bool Database::is_read_only() const { return sqlite3_db_readonly(db_.get(), "main") == 1; }

void Database::fail(int code) const {
  const Advice a = advice(code);
  damaged_ = damaged_ || a.kind == StoreFault::kCorrupt || a.kind == StoreFault::kNotADatabase;
  throw StoreError(a.kind, path_ + ": " + sqlite3_errmsg(db_.get()) + " (SQLite " + std::to_string(code) +
                               "); " + a.what_to_do);
}

Database::Prepared Database::take(std::string_view sql) {
  if (auto idle = prepared_.find(sql); idle != prepared_.end() && idle->second != nullptr)
    return std::move(idle->second);
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v3(db_.get(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  Prepared prepared(statement);
  if (code != SQLITE_OK) fail(code);
  if (!prepared) throw std::invalid_argument("empty SQL statement");
  return prepared;
}

void Database::give_back(std::string_view sql, Prepared statement) {
  prepared_.insert_or_assign(std::string(sql), std::move(statement));
}

Statement::Statement(Database& db, std::string_view sql) : db_(db), sql_(sql), statement_(db.take(sql)) {}

Statement::~Statement() {
  rewind();
  db_.give_back(sql_, std::move(statement_));
}

void Statement::rewind() {
  sqlite3_reset(statement_.get());  // its code repeats the error of the last step, which was thrown there
  sqlite3_clear_bindings(statement_.get());
}

void Statement::check(int code) const {
  if (code != SQLITE_OK) db_.fail(code);
}

bool Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) db_.fail(code);
  return false;
}

void Statement::bind_one(int index, std::int64_t value) {
  check(sqlite3_bind_int64(statement_.get(), index, value));
}

void Statement::bind_one(int index, double value) {
  if (!std::isfinite(value)) throw std::invalid_argument("a number that is not finite cannot be stored");
  check(sqlite3_bind_double(statement_.get(), index, value));
}

void Statement::bind_one(int index, std::string_view value) {
  // An empty view may hold no address, which SQLite would take for NULL.
  const char* data = value.data() == nullptr ? "" : value.data();
  check(sqlite3_bind_text64(statement_.get(), index, data, value.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
}

void Statement::bind_one(int index, const std::vector<std::uint8_t>& value) {
  if (value.empty()) return check(sqlite3_bind_zeroblob(statement_.get(), index, 0));
  check(sqlite3_bind_blob64(statement_.get(), index, value.data(), value.size(), SQLITE_TRANSIENT));
}

void Statement::bind_one(int index, std::nullopt_t) { check(sqlite3_bind_null(statement_.get(), index)); }

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
double Statement::real(int column) const { return sqlite3_column_double(statement_.get(), column); }

bool Statement::is_null(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
}

std::optional<double> Statement::maybe_real(int column) const {
  if (is_null(column)) return std::nullopt;
  return real(column);
}

std::optional<std::int64_t> Statement::maybe_integer(int column) const {
  if (is_null(column)) return std::nullopt;
  return integer(column);
}

std::string Statement::text(int column) const {
  const auto* data = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return data == nullptr ? std::string() : std::string(data, static_cast<std::size_t>(size));
}

std::vector<std::uint8_t> Statement::blob(int column) const {
  const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), column));
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return data == nullptr ? std::vector<std::uint8_t>() : std::vector<std::uint8_t>(data, data + size);
}

Transaction::Transaction(Database& db) : db_(db) { db_.execute("BEGIN IMMEDIATE"); }

Transaction::~Transaction() {
  // After a full disk SQLite may have rolled back by itself; then there is nothing to undo.
  if (open_ && sqlite3_get_autocommit(db_.db_.get()) == 0)
    sqlite3_exec(db_.db_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  db_.execute("COMMIT");
  open_ = false;
}

Snapshot::Snapshot(Database& db) : db_(db) { db_.execute("BEGIN"); }

Snapshot::~Snapshot() { sqlite3_exec(db_.db_.get(), "ROLLBACK", nullptr, nullptr, nullptr); }

}  // namespace ballbar

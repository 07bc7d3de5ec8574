#include "store/maintenance.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <set>

#include "store/set_aside.hpp"

namespace ballbar {

namespace {

constexpr int kRunsPerStep = 5;  // each has some 200 rows, a recording is one

std::int64_t changes(Database& db) { return db.integer("SELECT changes()"); }

std::vector<std::string> robots(Database& db) {
  std::vector<std::string> names;
  Statement query(db,  // from name to name by the index: DISTINCT would walk through all runs
                  "WITH RECURSIVE known (name) AS (SELECT min(robot) FROM run UNION ALL "
                  "SELECT (SELECT min(robot) FROM run WHERE robot > name) FROM known WHERE name IS NOT NULL) "
                  "SELECT name FROM known WHERE name IS NOT NULL");
  while (query.step()) names.push_back(query.text(0));
  return names;
}

/// Neither a producer whose clock is years behind nor one that is years ahead makes its runs old.
std::int64_t newest(Database& db, const std::string& robot, std::int64_t now_us) {
  Statement query(db, "SELECT max(started_us) FROM run WHERE robot = ?1");
  query.bind(robot).step();
  return std::min(now_us, query.integer(0));
}

/// Deletes the recordings of the next runs older than `before_us`, and remembers how far it came.
std::int64_t clear_traces(Database& db, const std::string& robot, std::int64_t before_us, int most,
                          std::int64_t& cleared_us) {
  std::int64_t removed = 0;
  Statement old(db,
                "SELECT id, started_us FROM run WHERE robot = ?1 AND started_us > ?2 AND started_us < ?3 "
                "ORDER BY started_us LIMIT ?4");
  old.bind(robot, cleared_us, before_us, most);
  Statement drop(db, "DELETE FROM trace WHERE run_id = ?1");
  while (old.step()) {
    drop.bind(old.integer(0)).run();
    removed += changes(db);
    cleared_us = old.integer(1);
  }
  return removed;
}

/// @param robot  nothing: of all
std::int64_t delete_diagnoses(Database& db, const std::optional<std::string>& robot, std::int64_t before_us,
                              int most) {
  Statement(db,
            "DELETE FROM gap_result WHERE id IN (SELECT id FROM gap_result WHERE (?1 IS NULL OR robot = ?1) "
            "AND ended_us < ?2 ORDER BY ended_us LIMIT ?3)")
      .bind(robot, before_us, most)
      .run();
  return changes(db);
}

/// The newest id stays: it would be given again, and who follows by id would miss that event.
std::int64_t delete_events(Database& db, const std::optional<std::string>& robot, std::int64_t before_us,
                           int most) {
  Statement(db,
            "DELETE FROM alarm_event WHERE id IN (SELECT id FROM alarm_event WHERE at_us < ?2 AND "
            "(?1 IS NULL OR robot = ?1) AND id < (SELECT max(id) FROM alarm_event) ORDER BY at_us LIMIT ?3)")
      .bind(robot, before_us, most)
      .run();
  return changes(db);
}

/// Percent-encoded, as SQLite wants the name of an attached file that it may only read.
std::string read_only_uri(const std::string& path) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).string()) {
    if (c == '?' || c == '#' || c == '%') {
      constexpr char kDigits[] = "0123456789ABCDEF";
      uri += '%';
      uri += kDigits[static_cast<unsigned char>(c) >> 4];
      uri += kDigits[static_cast<unsigned char>(c) & 15];
    } else {
      uri += c;
    }
  }
  return uri + "?mode=ro";
}

void require_no_file(const std::string& path) {
  std::error_code none;
  if (std::filesystem::exists(path, none))
    throw StoreError(StoreFault::kCannotOpen, path + ": is there already; choose another name");
}

[[noreturn]] void fail_on(const std::string& path, const std::string& what) {
  throw StoreError(StoreFault::kOther, path + ": " + what + ": " + std::strerror(errno));
}

/// VACUUM INTO leaves that to the kernel, and a power cut would leave an empty file.
void sync_to_disk(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool done = fd >= 0 && ::fsync(fd) == 0;
  const int why = errno;
  if (fd >= 0) ::close(fd);
  errno = why;
  if (!done) fail_on(path, "cannot be written to the disk");
}

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

/// A name, once it stands on the disk, stands there for good.
void put_in_place(const std::string& draft, const std::string& path) {
  sync_to_disk(draft);
  std::filesystem::rename(draft, path);
  sync_to_disk(folder_of(path));
}

/// The owner of what was there, or of its folder: root restores, and the service must be able to write.
void give_to_owner_of(const std::string& like, const std::string& path) {
  struct stat was {};
  if (::stat(like.c_str(), &was) != 0) fail_on(like, "cannot be looked at");
  if (::chown(path.c_str(), was.st_uid, was.st_gid) != 0 && errno != EPERM)
    fail_on(path, "cannot be given to its owner");
  const mode_t mode = S_ISREG(was.st_mode) ? was.st_mode & 07777 : 0640;
  if (::chmod(path.c_str(), mode) != 0) fail_on(path, "cannot be given its permissions");
}

/// @throws StoreError where another program has it open: that one would go on writing to what is set aside
void require_unused(const std::string& path) {
  try {
    Database db(path, Database::Mode::kReadWrite, 0);
    db.set_checkpoint_on_close(false);
    db.execute("PRAGMA locking_mode = EXCLUSIVE");
    db.integer("SELECT count(*) FROM sqlite_schema");  // takes the lock
  } catch (const StoreError& error) {
    if (error.kind() != StoreFault::kLocked) return;  // damaged, or none: that is why one restores
    throw StoreError(StoreFault::kLocked,
                     path +
                         ": is in use; stop ballbard (systemctl stop ballbard) and close what reads it, "
                         "then try again");
  }
}

/// What sqlite itself finds, and recordings whose own checksum or size is wrong.
std::vector<std::string> damages_of(Store& store) {
  std::vector<std::string> found;
  Database& db = store.database();
  Statement integrity(db, "PRAGMA integrity_check");
  while (integrity.step())
    if (integrity.text(0) != "ok") found.push_back(integrity.text(0));
  Statement references(db, "PRAGMA foreign_key_check");
  while (references.step())
    found.push_back("table " + references.text(0) + ", row " + references.text(1) + ": no such " +
                    references.text(2));
  Statement recordings(db, "SELECT run_id FROM trace");
  while (recordings.step()) {
    try {
      store.trace(recordings.integer(0));
    } catch (const StoreError& error) {
      found.push_back(error.what());
    }
  }
  return found;
}

/// The ids of a table, from as many sides as it takes: each scan ends where a page is damaged.
std::set<std::int64_t> ids(Database& db, const std::vector<std::string>& scans) {
  std::set<std::int64_t> found;
  for (const std::string& scan : scans) {
    try {
      Statement query(db, scan);
      while (query.step()) found.insert(query.integer(0));
    } catch (const StoreError&) {  // what came before it counts
    }
  }
  return found;
}

/// Columns that both databases have, but `without`. @param prefix  e.g. "o."
std::string columns(Database& db, const std::string& table, const std::set<std::string>& without) {
  std::string list;
  Statement query(db,
                  "SELECT name FROM pragma_table_info(?1, 'main') WHERE name IN "
                  "(SELECT name FROM pragma_table_info(?1, 'old'))");
  query.bind(table);
  while (query.step())
    if (!without.contains(query.text(0))) list += ", " + query.text(0);
  return list;
}

/// Tables whose rows belong to a run.
std::vector<std::string> parts_of_run(Database& db) {
  std::vector<std::string> tables;
  Statement query(db,
                  "SELECT t.name FROM main.sqlite_schema t JOIN pragma_table_info(t.name, 'main') c "
                  "WHERE t.type = 'table' AND c.name = 'run_id' AND t.name <> 'alarm_event' AND EXISTS "
                  "(SELECT 1 FROM old.sqlite_schema o WHERE o.name = t.name)");
  while (query.step()) tables.push_back(query.text(0));
  return tables;
}

class Recovery {
 public:
  explicit Recovery(Database& db)
      : db_(db), run_columns_(columns(db, "run", {"id"})), tables_(parts_of_run(db)) {
    for (const std::string& table : tables_) part_columns_.push_back(columns(db, table, {"run_id"}));
  }

  void take_run(std::int64_t old_id) {
    Transaction together(db_);
    const std::string list = run_columns_.substr(2);
    try {
      Statement copy(db_, "INSERT OR IGNORE INTO main.run (" + list + ") SELECT " + list +
                              " FROM old.run WHERE id = ?1 RETURNING id");
      copy.bind(old_id);
      if (!copy.step()) return;  // is there already
      const std::int64_t id = copy.integer(0);
      copy.run();
      for (std::size_t i = 0; i < tables_.size(); ++i) take_part(i, old_id, id);
      together.commit();
      ++recovered.runs;
    } catch (const StoreError& error) {
      if (error.kind() != StoreFault::kCorrupt) throw;
      ++recovered.lost;
    }
  }

  Recovered recovered;

 private:
  void take_part(std::size_t table, std::int64_t old_id, std::int64_t id) {
    const std::string& list = part_columns_[table];
    try {
      Statement copy(db_, "INSERT INTO main." + tables_[table] + " (run_id" + list + ") SELECT ?2" + list +
                              " FROM old." + tables_[table] + " WHERE run_id = ?1");
      copy.bind(old_id, id).run();
      if (tables_[table] == "trace") recovered.traces += changes(db_);
    } catch (const StoreError& error) {
      if (error.kind() != StoreFault::kCorrupt) throw;
      ++recovered.lost;
    }
  }

  Database& db_;
  std::string run_columns_;
  std::vector<std::string> tables_, part_columns_;
};

/// @param damaged  known as `old` from here on
Recovery attach(Database& db, const std::string& damaged) {
  const std::string nothing = damaged + ": nothing of it can be read: ";
  const std::string advice = "; restore a backup (ballbar db restore), and move this file away";
  try {
    Statement(db, "ATTACH ?1 AS old").bind(read_only_uri(damaged)).run();
    if (db.integer("SELECT count(*) FROM old.sqlite_schema WHERE name IN ('run', 'alarm_event', "
                   "'alarm_state')") != 3)
      throw StoreError(StoreFault::kForeign, nothing + "it has no tables of ballbard" + advice);
    return Recovery(db);
  } catch (const StoreError& error) {
    if (error.kind() != StoreFault::kCorrupt && error.kind() != StoreFault::kNotADatabase) throw;
    throw StoreError(error.kind(), nothing + error.what() + advice);
  }
}

/// States, where they can be read and nothing was judged since. An id that was given again meanwhile becomes
/// another one.
void take_alarm_states(Database& db) {
  const std::string list = columns(db, "alarm_state", {"id"});
  const std::int64_t known = db.integer("SELECT max(id) FROM main.alarm_state");
  try {
    if (db.integer("SELECT count(*) FROM pragma_table_info('alarm_state', 'old') WHERE name = 'id'") == 0)
      return db.execute("INSERT OR IGNORE INTO main.alarm_state (" + list.substr(2) + ") SELECT " +
                        list.substr(2) + " FROM old.alarm_state");
    const std::int64_t most = std::max(known, db.integer("SELECT max(id) FROM old.alarm_state"));
    db.execute("INSERT OR IGNORE INTO main.alarm_state (id" + list +
               ") SELECT CASE WHEN o.id > 0 AND EXISTS (SELECT 1 FROM main.alarm_state s WHERE s.id = o.id) "
               "THEN o.id + " +
               std::to_string(most) + " ELSE o.id END" + list + " FROM old.alarm_state o");
  } catch (const StoreError& error) {
    if (error.kind() != StoreFault::kCorrupt) throw;
  }
}

/// Events, where they can be read, before those that are there and in sequence: who follows by id has been
/// told of them long ago.
void take_alarm_events(Database& db) {
  const std::string list = columns(db, "alarm_event", {"id", "run_id", "alarm_id"});
  std::string copy = "INSERT INTO main.alarm_event (id, run_id, alarm_id" + list;
  copy.append(
      ") SELECT ?2, (SELECT id FROM main.run r WHERE r.robot = o.robot AND r.started_us = o.run_started_us), "
      "coalesce((SELECT s.id FROM main.alarm_state s WHERE s.rule = o.rule AND s.robot = o.robot AND "
      "s.test = o.test AND s.direction = o.direction AND s.axis = o.axis), 0)");
  copy.append(list).append(
      " FROM old.alarm_event o WHERE o.id = ?1 AND NOT EXISTS (SELECT 1 FROM main.alarm_event e WHERE "
      "e.at_us = o.at_us AND e.rule = o.rule AND e.robot = o.robot AND e.test = o.test AND "
      "e.direction = o.direction AND e.axis = o.axis AND e.to_state = o.to_state)");
  const std::set<std::int64_t> found = ids(
      db, {"SELECT id FROM old.alarm_event ORDER BY id", "SELECT id FROM old.alarm_event ORDER BY id DESC"});
  std::int64_t below =
      std::min<std::int64_t>(1, db.integer("SELECT coalesce(min(id), 1) FROM main.alarm_event"));
  for (auto id = found.rbegin(); id != found.rend(); ++id) {
    try {
      Statement insert(db, copy);
      insert.bind(*id, below - 1).run();
      below -= changes(db);
    } catch (const StoreError& error) {
      if (error.kind() != StoreFault::kCorrupt) throw;
    }
  }
}

}  // namespace

Removed Retention::step(Store& store, const RetentionLimits& limits, std::int64_t now_us, int most) {
  Database& db = store.database();
  Removed removed;
  std::map<std::string, std::int64_t> cleared_us = cleared_us_;  // counts only if it was committed
  Transaction transaction(db);
  const int runs_at_once = std::min(most, kRunsPerStep);
  for (const std::string& robot : robots(db)) {
    const std::int64_t latest = newest(db, robot, now_us);
    if (limits.keep_traces_us > 0)
      removed.traces += clear_traces(db, robot, latest - limits.keep_traces_us, most, cleared_us[robot]);
    if (limits.keep_us == 0) continue;
    const std::int64_t before_us = latest - limits.keep_us;
    Statement(db,
              "DELETE FROM run WHERE id IN (SELECT id FROM run WHERE robot = ?1 AND started_us < ?2 "
              "ORDER BY started_us LIMIT ?3)")
        .bind(robot, before_us, runs_at_once)
        .run();
    removed.runs += changes(db);
    removed.diagnoses += delete_diagnoses(db, robot, before_us, runs_at_once);
    removed.events += delete_events(db, robot, before_us, most);
  }
  if (limits.keep_us > 0)  // of ballbard itself
    removed.events += delete_events(
        db, "", std::min(now_us, db.integer("SELECT max(at_us) FROM alarm_event")) - limits.keep_us, most);
  if (limits.max_bytes > 0 && removed.none() && data_bytes(store) > limits.max_bytes) {
    Statement(db, "DELETE FROM trace WHERE run_id IN (SELECT run_id FROM trace ORDER BY run_id LIMIT ?1)")
        .bind(most)
        .run();
    removed.traces += changes(db);
    if (removed.traces == 0) {
      Statement(db, "DELETE FROM run WHERE id IN (SELECT id FROM run ORDER BY started_us LIMIT ?1)")
          .bind(runs_at_once)
          .run();
      removed.runs += changes(db);
      // Diagnoses and events of what is gone go too, or they would push out all runs in the end.
      Statement oldest(db, "SELECT min(started_us) FROM run");
      const std::int64_t before_us = oldest.step() && !oldest.is_null(0) ? oldest.integer(0) : INT64_MAX;
      removed.diagnoses += delete_diagnoses(db, std::nullopt, before_us, most);
      removed.events += delete_events(db, std::nullopt, before_us, most);
    }
  }
  if (!removed.none()) transaction.commit();
  cleared_us_ = std::move(cleared_us);
  return removed;
}

std::int64_t data_bytes(Store& store) {
  Database& db = store.database();
  return (db.integer("PRAGMA page_count") - db.integer("PRAGMA freelist_count")) *
         db.integer("PRAGMA page_size");
}

void backup(const std::string& from, const std::string& to) {
  require_no_file(to);
  Store source = Store::open_read_only(from);
  const std::string draft = to + ".part";
  std::error_code none;
  std::filesystem::remove(draft, none);
  try {
    Statement(source.database(), "VACUUM INTO ?1").bind(draft).run();
    const std::vector<std::string> wrong = damages(draft);
    if (!wrong.empty())
      throw StoreError(StoreFault::kCorrupt,
                       from + ": damaged: " + wrong.front() + "; see: ballbar db check");
    put_in_place(draft, to);
  } catch (...) {
    std::filesystem::remove(draft, none);
    throw;
  }
}

std::vector<std::string> damages(const std::string& path) {
  try {
    Store store = Store::open_read_only(path);
    return damages_of(store);
  } catch (const StoreError& error) {
    if (error.kind() != StoreFault::kCorrupt && error.kind() != StoreFault::kNotADatabase) throw;
    return {error.what()};
  }
}

std::string restore(const std::string& backup_path, const std::string& path) {
  const std::vector<std::string> wrong = damages(backup_path);
  if (!wrong.empty())
    throw StoreError(StoreFault::kCorrupt,
                     backup_path + ": damaged: " + wrong.front() + "; choose another backup");
  const std::string draft = path + ".restored";
  std::error_code none;
  const bool there = std::filesystem::exists(path, none);
  if (there) require_unused(path);
  std::filesystem::remove(draft, none);
  {
    Store source = Store::open_read_only(backup_path);
    Statement(source.database(), "VACUUM INTO ?1").bind(draft).run();
  }
  give_to_owner_of(there ? path : folder_of(path), draft);
  sync_to_disk(draft);
  std::string aside = there ? set_aside(path, "before-restore") : "";
  put_in_place(draft, path);
  return aside;
}

Recovered recover(const std::string& damaged, Store& into) {
  std::error_code none;
  if (!std::filesystem::exists(damaged, none))
    throw StoreError(StoreFault::kCannotOpen, damaged + ": there is no such file; check the path");
  Database& db = into.database();
  Recovery recovery = attach(db, damaged);
  for (const std::int64_t id :
       ids(db, {"SELECT id FROM old.run ORDER BY id", "SELECT id FROM old.run ORDER BY id DESC",
                "SELECT id FROM old.run INDEXED BY run_time ORDER BY started_us",
                "SELECT id FROM old.run INDEXED BY run_time ORDER BY started_us DESC"}))
    recovery.take_run(id);
  take_alarm_states(db);
  take_alarm_events(db);
  db.forget_statements();
  db.execute("DETACH old");
  return recovery.recovered;
}

}  // namespace ballbar

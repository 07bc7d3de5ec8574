#include "store/maintenance.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

#include "store/set_aside.hpp"

namespace ballbar {

namespace {

constexpr int kRunsPerStep = 5;  // each has some 200 rows, a recording is one

std::int64_t changes(Database& db) { return db.integer("SELECT changes()"); }

std::vector<std::string> robots(Database& db) {
  std::vector<std::string> names;
  Statement query(db, "SELECT DISTINCT robot FROM run");
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

/// Alarms, where they can be read; the states only where nothing was judged since.
void take_alarms(Database& db) {
  const std::string list = columns(db, "alarm_event", {"id", "run_id"});
  const std::string common = columns(db, "alarm_state", {}).substr(2);
  std::string copy = "INSERT INTO main.alarm_event (run_id" + list;
  copy.append(
      ") SELECT (SELECT id FROM main.run r WHERE r.robot = o.robot AND r.started_us = o.run_started_us)");
  copy.append(list).append(" FROM old.alarm_event o WHERE o.id = ?1");
  for (const std::int64_t id : ids(db, {"SELECT id FROM old.alarm_event ORDER BY id",
                                        "SELECT id FROM old.alarm_event ORDER BY id DESC"})) {
    try {
      Statement(db, copy).bind(id).run();
    } catch (const StoreError& error) {
      if (error.kind() != StoreFault::kCorrupt) throw;
    }
  }
  try {
    db.execute("INSERT OR IGNORE INTO main.alarm_state (" + common + ") SELECT " + common +
               " FROM old.alarm_state");
  } catch (const StoreError& error) {
    if (error.kind() != StoreFault::kCorrupt) throw;
  }
}

}  // namespace

Removed Retention::step(Store& store, const RetentionLimits& limits, std::int64_t now_us, int most) {
  Database& db = store.database();
  Removed removed;
  Transaction transaction(db);
  for (const std::string& robot : robots(db)) {
    const std::int64_t latest = newest(db, robot, now_us);
    if (limits.keep_traces_us > 0)
      removed.traces += clear_traces(db, robot, latest - limits.keep_traces_us, most, cleared_us_[robot]);
    if (limits.keep_us == 0) continue;
    Statement(db,
              "DELETE FROM run WHERE id IN (SELECT id FROM run WHERE robot = ?1 AND started_us < ?2 "
              "ORDER BY started_us LIMIT ?3)")
        .bind(robot, latest - limits.keep_us, std::min(most, kRunsPerStep))
        .run();
    removed.runs += changes(db);
    Statement(
        db,
        // The newest id stays: it would be given again, and who follows by id would miss that event.
        "DELETE FROM alarm_event WHERE id IN (SELECT id FROM alarm_event WHERE at_us < ?2 AND robot = ?1 "
        "AND id < (SELECT max(id) FROM alarm_event) ORDER BY at_us LIMIT ?3)")
        .bind(robot, latest - limits.keep_us, most)
        .run();
    removed.events += changes(db);
  }
  if (limits.max_bytes > 0 && removed.none() && data_bytes(store) > limits.max_bytes) {
    Statement(db, "DELETE FROM trace WHERE run_id IN (SELECT run_id FROM trace ORDER BY run_id LIMIT ?1)")
        .bind(most)
        .run();
    removed.traces += changes(db);
    if (removed.traces == 0) {
      Statement(db, "DELETE FROM run WHERE id IN (SELECT id FROM run ORDER BY started_us LIMIT ?1)")
          .bind(std::min(most, kRunsPerStep))
          .run();
      removed.runs += changes(db);
    }
  }
  if (!removed.none()) transaction.commit();
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
    std::filesystem::rename(draft, to);
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
  std::filesystem::remove(draft, none);
  {
    Store source = Store::open_read_only(backup_path);
    Statement(source.database(), "VACUUM INTO ?1").bind(draft).run();
  }
  std::string aside;
  if (std::filesystem::exists(path)) aside = set_aside(path, "before-restore");
  std::filesystem::rename(draft, path);
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
  take_alarms(db);
  db.forget_statements();
  db.execute("DETACH old");
  return recovery.recovered;
}

}  // namespace ballbar

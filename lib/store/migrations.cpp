#include "store/migrations.hpp"

#include <string>

#include "store/schema.hpp"

namespace ballbar {

Identity identify(Database& db, int newest) {
  const std::int64_t application = db.integer("PRAGMA application_id");
  const std::int64_t version = db.integer("PRAGMA user_version");
  if (application != kApplicationId) {
    const bool empty =
        application == 0 && version == 0 && db.integer("SELECT count(*) FROM sqlite_schema") == 0;
    if (empty) return Identity::kEmpty;
    throw StoreError(
        StoreFault::kForeign,
        db.path() + ": this is a database of another application; it was left as it is, choose another path");
  }
  if (version < 0 || version > newest)
    throw StoreError(StoreFault::kNewer,
                     db.path() + ": written by a newer ballbard (schema " + std::to_string(version) +
                         ", this one knows " + std::to_string(newest) +
                         "); it was left as it is, upgrade ballbard or choose another path");
  return Identity::kOurs;
}

void migrate(Database& db, std::span<const char* const> steps) {
  const int newest = static_cast<int>(steps.size());
  while (identify(db, newest) == Identity::kEmpty || db.integer("PRAGMA user_version") < newest) {
    Transaction transaction(db);
    // Read again under the lock: another process may have been first.
    const std::int64_t version = db.integer("PRAGMA user_version");
    if (version < newest) {
      db.execute(steps[static_cast<std::size_t>(version)]);
      db.execute("PRAGMA application_id = " + std::to_string(kApplicationId) +
                 "; PRAGMA user_version = " + std::to_string(version + 1));
    }
    transaction.commit();
  }
}

void refresh_views(Database& db) {
  std::string stale;
  for (const View& view : schema_views()) {
    Statement query(db, "SELECT sql FROM sqlite_schema WHERE type = 'view' AND name = ?1");
    query.bind(view.name);
    if (!query.step() || query.text(0) != view.sql)
      stale += "DROP VIEW IF EXISTS " + view.name + ";\n" + view.sql + ";\n";
  }
  if (stale.empty()) return;
  Transaction transaction(db);
  db.execute(stale);
  transaction.commit();
}

}  // namespace ballbar

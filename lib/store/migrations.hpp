#pragma once
/// Whose database is this, of which version, and how it comes up to date.

#include <span>

#include "store/sqlite.hpp"

namespace ballbar {

enum class Identity { kEmpty, kOurs };

/// Reads only. @throws StoreError kForeign for another application's database, kNewer for one of a newer
/// version
/// @param newest  version that this program writes
Identity identify(Database& db, int newest);

/// Brings the tables to version steps.size(), each step in its own transaction: a step that fails leaves the
/// version before it. @throws StoreError as identify(), and where a step fails
void migrate(Database& db, std::span<const char* const> steps);

/// Writes the views of schema_views() where they differ; a database that is up to date is not written to.
void refresh_views(Database& db);

}  // namespace ballbar

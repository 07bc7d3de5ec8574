#pragma once
/// The SQL of the tables and views. Explained for people in docs/database.md.

#include <span>
#include <string>
#include <vector>

namespace ballbar {

/// 'BALB' in the file's header: `file` and other programs can tell whose database it is.
inline constexpr int kApplicationId = 0x42414c42;

/// Step i brings a database of version i to version i + 1. Append only: a released step is never edited.
std::span<const char* const> schema_steps();

struct View {
  std::string name;
  std::string sql;  ///< CREATE VIEW ..., exactly as SQLite keeps it
};

/// Views hold no data and take their columns from the catalogue of quantities, so they are no steps: they are
/// written anew whenever they differ. A new published number appears in them by itself.
std::vector<View> schema_views();

}  // namespace ballbar

/// ballbar db backup, db restore, db check, db recover

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>

#include "core/error.hpp"
#include "daemon/tool.hpp"
#include "store/maintenance.hpp"
#include "store/set_aside.hpp"

namespace ballbar {
namespace {

struct DatabaseOptions {
  Where where;
  std::string file;
};

std::string path_of(const DatabaseOptions& options) {
  return options.where.db_path.empty() ? load_config(options.where.config_path).store_path
                                       : options.where.db_path;
}

int back_up(const DatabaseOptions& options) {
  backup(path_of(options), options.file);
  Store copy = Store::open_read_only(options.file);
  std::cout << options.file << ": " << copy.counts().runs << " runs, checked\n";
  return 0;
}

int restore_backup(const DatabaseOptions& options) {
  const std::string path = path_of(options);
  const std::string aside = restore(options.file, path);
  std::cout << path << ": restored, " << Store::open_read_only(path).counts().runs << " runs\n";
  if (!aside.empty()) std::cout << "the database that was there is now " << aside << "\n";
  return 0;
}

int check_database(const DatabaseOptions& options) {
  const std::string path = path_of(options);
  const std::vector<std::string> wrong = damages(path);
  for (const std::string& line : wrong) std::cout << line << "\n";
  if (wrong.empty()) {
    std::cout << path << " is sound: " << Store::open_read_only(path).counts().runs << " runs\n";
    return 0;
  }
  std::cout << path
            << " is damaged; restore a backup (ballbar db restore), or get out what can be read: stop "
            << "ballbard, move the file away, and ballbar db recover FILE\n";
  return 1;
}

/// By ballbard, which gives its alarm as long as the file has this name.
bool was_set_aside(const std::string& file, const std::string& path) {
  const std::vector<std::string> all = set_aside_before(path);
  return std::any_of(all.begin(), all.end(), [&file](const std::string& one) {
    std::error_code error;
    return std::filesystem::equivalent(one, file, error);
  });
}

int recover_database(const DatabaseOptions& options) {
  const std::string path = path_of(options);
  Store into(path);
  const Recovered found = recover(options.file, into);
  std::cout << path << ": " << found.runs << " runs recovered, " << found.traces << " with their recording; "
            << found.lost << " runs or parts of runs could not be read\n";
  if (was_set_aside(options.file, path))
    std::cout << options.file << " is now " << set_aside(options.file, "recovered") << "\n";
  return found.lost == 0 ? 0 : 1;
}

}  // namespace

void add_db(CLI::App& app, Action& action) {
  CLI::App* db = app.add_subcommand("db", "back up, restore, check and repair the database");
  db->require_subcommand(1);
  const auto add = [db, &action](const std::string& name, const std::string& about,
                                 int (*verb)(const DatabaseOptions&)) {
    auto options = std::make_shared<DatabaseOptions>();
    CLI::App* sub = db->add_subcommand(name, about);
    options->where.add_to(*sub);
    sub->callback([options, verb, &action] { action = [options, verb] { return verb(*options); }; });
    return std::pair(sub, options);
  };
  const auto with_file = [&add](const std::string& name, const std::string& about, const std::string& file,
                                int (*verb)(const DatabaseOptions&)) {
    const auto [sub, options] = add(name, about, verb);
    sub->add_option("FILE", options->file, file)->required();
  };
  with_file("backup", "a tidy, checked copy; the service may go on running",
            "where to; must not be there yet", back_up);
  with_file("restore", "a backup in the database's place, which is set aside; stop ballbard before",
            "the backup", restore_backup);
  add("check", "read every page, reference and recording; exit code 1 where something is damaged",
      check_database);
  with_file(
      "recover",
      "what can still be read of a damaged database into the configured one, beside the runs that it has",
      "the damaged database; where ballbard set it aside, it is renamed afterwards, and the alarm ends",
      recover_database);
}

}  // namespace ballbar

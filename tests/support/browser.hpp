#pragma once
/// A page as a browser without a screen shows it.

#include <filesystem>
#include <string>
#include <vector>

#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar::test {

inline bool has_program(const std::string& name) { return std::filesystem::exists("/usr/bin/" + name); }

/// Chromium with a new profile, which talks to nobody. Its messages, with those of the page's console, are in
/// err.
inline Outcome chromium(std::vector<std::string> options, const std::string& page) {
  const TempDir profile;
  std::vector<std::string> command{"chromium",
                                   "--headless",
                                   "--no-sandbox",
                                   "--disable-gpu",
                                   "--disable-dev-shm-usage",
                                   "--disable-quic",
                                   "--no-first-run",
                                   "--disable-background-networking",
                                   "--disable-component-update",
                                   "--disable-sync",
                                   "--enable-logging=stderr",
                                   "--user-data-dir=" + profile.path()};
  command.insert(command.end(), options.begin(), options.end());
  command.push_back("file://" + page);
  return run(std::move(command));
}

}  // namespace ballbar::test

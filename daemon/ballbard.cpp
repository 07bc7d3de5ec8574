/// ballbard: the service.

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>

#include "bus/receiver.hpp"
#include "core/error.hpp"
#include "daemon/daemon.hpp"
#include "daemon/series_diagnosis.hpp"
#include "version.hpp"

int main(int argc, char** argv) {
  // The receiver: this program again, started by itself (see bus/receiver.hpp).
  if (argc == 4 && std::strcmp(argv[1], "--receive") == 0)
    return ballbar::run_receiver(argv[2], std::atoi(argv[3]));

  // A diagnosis beside the service: likewise (see daemon/live_diagnosis.hpp).
  if (argc == 6 && std::strcmp(argv[1], "--diagnose") == 0)
    return ballbar::run_series_diagnosis({argv + 2, argv + argc});

  CLI::App app(
      "Hears ballbar, interferometer and joint streams over LCM, analyses every circle and line, stores all, "
      "judges by rules.",
      "ballbard");
  std::string config_path = ballbar::kDefaultConfig;
  app.add_option("--config", config_path, "configuration file")->capture_default_str();
  app.set_version_flag("--version", ballbar::kVersion);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
    ballbar::Daemon daemon(ballbar::load_config(config_path), program);
    return daemon.run() < 0 ? 3 : 0;
  } catch (const ballbar::Error& error) {
    ballbar::log_line(ballbar::Priority::kError, error.what());
    return error.cause() == ballbar::Cause::kInput ? 2 : 3;
  } catch (const std::exception& error) {
    ballbar::log_line(ballbar::Priority::kError, std::string("not foreseen: ") + error.what());
    return 3;
  }
}

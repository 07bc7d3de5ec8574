/// ballbar: the tool that people type.

#include <CLI/CLI.hpp>
#include <iostream>

#include "core/error.hpp"
#include "daemon/tool.hpp"
#include "version.hpp"

int main(int argc, char** argv) {
  CLI::App app("Ballbar and straightness measurements of robots: replay, look at, export, plot; check rules and configuration.",
               "ballbar");
  app.set_version_flag("--version", ballbar::kVersion);
  app.require_subcommand(1);
  app.footer("Exit codes: 0 done, 1 the answer is no (a check failed), 2 bad use or bad input, 3 the world failed (no database, no bus).");
  ballbar::Action action;
  ballbar::add_replay(app, action);
  ballbar::add_show(app, action);
  ballbar::add_export(app, action);
  ballbar::add_summary(app, action);
  ballbar::add_plot(app, action);
  ballbar::add_check(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    const int code = action();
    std::cout.flush();
    return code;
  } catch (const ballbar::Error& error) {
    std::cerr << "ballbar: " << error.what() << "\n";
    return error.cause() == ballbar::Cause::kInput ? 2 : 3;
  } catch (const std::exception& error) {
    std::cerr << "ballbar: not foreseen: " << error.what() << "\n";
    return 3;
  }
}

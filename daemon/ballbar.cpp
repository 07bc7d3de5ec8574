/// ballbar: the tool that people type.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/man_page.hpp"
#include "daemon/tool.hpp"
#include "version.hpp"

namespace {

/// CLI11's complaint as one line; where something is missing, with the first word that it could not place.
std::string one_line(const CLI::App* app, const CLI::Error& error) {
  std::string text = std::string("ballbar: ") + error.what();
  const std::vector<std::string> strange = app->remaining(true);
  if (!strange.empty() && error.get_exit_code() == static_cast<int>(CLI::ExitCodes::RequiredError))
    text += "; not understood: '" + strange.front() + "'";
  return text + "; see 'ballbar --help' and 'ballbar VERB --help'\n";
}

/// For the build: the manual page and the completion are made of the command line itself.
int print(const std::string& text) {
  std::cout << text << std::flush;
  return std::cout ? 0 : 3;
}

constexpr const char* kMore = R"(.SH FILES
.TP
.I /etc/ballbard/ballbard.toml
configuration, see \fBballbard.toml\fR(5)
.TP
.I /var/lib/ballbard/ballbard.db
the database; members of the group \fIballbard\fR may read it
.SH "SEE ALSO"
.BR ballbard (8),
.BR ballbard.toml (5),
.BR ballbar\-rules (5),
.BR ballbar\-spy (1)
)";

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Ballbar and straightness measurements of robots: replay, import, look at, export, plot, report, "
      "compare, simulate; "
      "check rules "
      "and configuration.",
      "ballbar");
  app.set_version_flag("--version", ballbar::kVersion);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 1 the answer is no (a check failed), 2 bad use or bad input, 3 the world failed "
      "(no database, no bus).");
  app.failure_message(one_line);
  ballbar::Action action;
  ballbar::add_replay(app, action);
  ballbar::add_import(app, action);
  ballbar::add_show(app, action);
  ballbar::add_alarms(app, action);
  ballbar::add_export(app, action);
  ballbar::add_summary(app, action);
  ballbar::add_plot(app, action);
  ballbar::add_report(app, action);
  ballbar::add_compare(app, action);
  ballbar::add_simulate(app, action);
  ballbar::add_diagnose(app, action);
  ballbar::add_baseline(app, action);
  ballbar::add_db(app, action);
  ballbar::add_check(app, action);
  const std::string wanted = argc == 2 ? argv[1] : "";
  if (wanted == "--man-page") return print(ballbar::man_page(app, ballbar::kVersion, kMore));
  if (wanted == "--bash-completion") return print(ballbar::bash_completion(app));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    const int code = action();
    std::cout.flush();
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout)
      throw ballbar::Error(ballbar::Cause::kWorld, "standard output cannot be written; is the disk full?");
    return code;
  } catch (const ballbar::Error& error) {
    std::cerr << "ballbar: " << error.what() << "\n";
    return error.cause() == ballbar::Cause::kInput ? 2 : 3;
  } catch (const std::exception& error) {
    std::cerr << "ballbar: not foreseen: " << error.what() << "\n";
    return 3;
  }
}

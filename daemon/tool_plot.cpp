/// ballbar plot

#include <map>
#include <memory>
#include <optional>

#include "core/error.hpp"
#include "daemon/pictures.hpp"
#include "daemon/rule_limits.hpp"
#include "daemon/tool.hpp"

namespace ballbar {
namespace {

struct PlotOptions {
  Where where;
  RunChoice chosen;
  std::string output;
  std::string kind;
  PictureOptions picture;
  bool with_setup = false;
};

const std::map<std::string, PictureKind> kKinds{{"polar", PictureKind::kPolar},
                                                {"line", PictureKind::kLine},
                                                {"harmonics", PictureKind::kHarmonics},
                                                {"trend", PictureKind::kTrend},
                                                {"ovality", PictureKind::kOvality}};

PictureKind kind_of(const PlotOptions& options, const std::vector<StoredRun>& runs) {
  if (!options.kind.empty()) return kKinds.at(options.kind);
  for (const StoredRun& stored : runs)
    if (stored.kind != runs.front().kind)
      throw Error(Cause::kInput,
                  "circles and lines do not go into one plot; choose one kind with --test or --kind");
  return runs.front().kind == TestKind::kCircle ? PictureKind::kPolar : PictureKind::kLine;
}

/// An option that the chosen kind has no use for is a mistake.
void check(const PlotOptions& options, PictureKind kind) {
  const auto refuse = [](const char* option, const char* what) {
    throw Error(Cause::kInput, std::string(option) + " is for " + what);
  };
  if (kind != PictureKind::kTrend) {
    if (!options.picture.quantity.empty()) refuse("--quantity", "--kind trend");
    if (!options.picture.limits_um.empty()) refuse("--limit-um", "--kind trend");
    if (options.picture.by_run) refuse("--by-run", "--kind trend");
  }
  if (kind != PictureKind::kHarmonics && options.with_setup) refuse("--with-order-1", "--kind harmonics");
  if (kind != PictureKind::kLine && !options.picture.axis.empty()) refuse("--axis", "lines");
}

int run(const PlotOptions& options) {
  const Store store = options.where.open();
  const std::vector<StoredRun> runs = options.chosen.runs(store, "ok", "plot");
  const PictureKind kind = kind_of(options, runs);
  check(options, kind);
  PictureOptions picture = options.picture;
  if (options.with_setup) picture.first_order = 1;
  if (kind == PictureKind::kTrend) picture.rules = configured_rules(options.where);
  render(picture_of(kind, store, runs, picture), options.output);
  return 0;
}

}  // namespace

void add_plot(CLI::App& app, Action& action) {
  auto options = std::make_shared<PlotOptions>();
  CLI::App* verb = app.add_subcommand(
      "plot", "circles as polar plot, harmonics or ovality vectors; lines; any figure over time");
  verb->add_option(
          "--kind", options->kind,
          "polar, line, harmonics (bars), trend (over time) or ovality (vectors with 95 % ellipses); "
          "default: polar or line, by the runs")
      ->check(CLI::IsMember({"polar", "line", "harmonics", "trend", "ovality"}));
  verb->add_option("--axis", options->picture.axis, "lines: only this direction of deviation")
      ->check(CLI::IsMember({"X", "Y", "Z"}));
  verb->add_option("--quantity", options->picture.quantity,
                   "trend: a figure of 'ballbar show', or harmonic<k>_um; default ovality_um, "
                   "straightness_mz_um for lines");
  verb->add_option("--limit-um", options->picture.limits_um,
                   "trend: further limits, as lines; those of the configured alarm rules are drawn anyway");
  verb->add_flag("--by-run", options->picture.by_run,
                 "trend: one step a run instead of time, where series lie days apart");
  verb->add_flag("--with-order-1", options->with_setup,
                 "harmonics: with order 1, which is how the ball was set up");
  verb->add_flag("--measured-only", options->picture.measured_only,
                 "without what the model predicts, which is drawn for up to four runs");
  verb->add_option("-o,--output", options->output, "picture to write: .svg or .png")->required();
  options->where.add_to(*verb);
  options->chosen.add_to(*verb);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar

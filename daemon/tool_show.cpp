/// ballbar list, show

#include <cstdio>
#include <iostream>
#include <memory>

#include "daemon/json_out.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "pipeline/catalogue.hpp"
#include "rules/rule.hpp"
#include "store/labels.hpp"

namespace ballbar {
namespace {

struct ShowOptions {
  Where where;
  Choice choice;
  std::string run;
  bool json = false;
};

std::string number(const Record& record, const char* name) {
  const auto found = record.values.find(name);
  if (found == record.values.end()) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", found->second.value);
  return text;
}

int list(const ShowOptions& options) {
  const std::vector<StoredRun> runs = options.choice.runs(options.where.open());
  if (options.json) {
    Json all = Json::array();
    for (const StoredRun& run : runs) all.push_back(to_json(run));
    std::cout << text_of(Json{{"runs", all}});
    return 0;
  }
  std::printf("%5s  %-19s  %-12s %-8s %-18s %-10s %10s %12s %12s  %-14s %s\n", "id", "begin (UTC)", "robot",
              "run", "series", "status", "ovality um", "circular um", "straight um", "source", "ended by");
  for (const StoredRun& run : runs)
    for (const Record& record : run.records) {
      const std::string name =
          run_name(run.test, run.direction, run.repetition) + (record.axis.empty() ? "" : " " + record.axis);
      std::printf("%5lld  %-19s  %-12s %-8s %-18s %-10s %10s %12s %12s  %-14s %s\n",
                  static_cast<long long>(run.id), utc_text(run.started_us).c_str(), run.robot.c_str(),
                  name.c_str(), run.series.c_str(), run.status.c_str(), number(record, "ovality_um").c_str(),
                  number(record, "circular_deviation_um").c_str(),
                  number(record, "straightness_mz_um").c_str(), run.source.c_str(), to_string(run.end));
    }
  return 0;
}

void print_figures(const Record& record) {
  for (const Quantity& quantity : catalogue()) {
    if (quantity.kind != record.kind && quantity.kind != "run") continue;
    const auto found = record.values.find(std::string(quantity.name));
    if (found == record.values.end()) continue;
    const Estimate& value = found->second;
    const std::string sd = value.sd ? [&] {
      char text[32];
      std::snprintf(text, sizeof text, "+- %.3f", *value.sd);
      return std::string(text);
    }() : std::string();
    std::printf("  %-34s %12.3f %-11s %s\n", std::string(quantity.name).c_str(), value.value, sd.c_str(),
                std::string(quantity.meaning).c_str());
  }
}

/// Measured beside predicted, where the model predicts: gap = measured - predicted.
void print_harmonics(const Json& run) {
  const Json measured = run.value("harmonics", Json::array());
  const Json gaps = run.value("gap_harmonics", Json::array());
  if (measured.empty()) return;
  std::printf("  harmonic     cos um     sin um  amplitude um   sd um%s\n",
              gaps.empty() ? "" : "   gap: cos um     sin um  amplitude um   sd um");
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const auto print = [](const char* format, const Json& h) {
      std::printf(format, h["cos_um"].get<double>(), h["sin_um"].get<double>(),
                  h["amplitude_um"].get<double>(), h["sd_um"].get<double>());
    };
    std::printf("  %8d", measured[i]["order"].get<int>());
    print(" %10.3f %10.3f %13.3f %7.3f", measured[i]);
    if (i < gaps.size()) print("   %11.3f %10.3f %13.3f %7.3f", gaps[i]);
    std::printf("\n");
  }
}

/// One frame's shapes, largest share first; a sum where only that is known.
void print_shapes(const Json& shapes) {
  std::printf("    %-18s %12s  %-11s %-5s %8s %11s\n", "shape", "value", "", "unit", "share", "without um");
  for (const Json& shape : shapes) {
    const double percent = 100.0 * shape["share"].get<double>();
    if (shape.contains("not_told_apart")) {
      std::string names;
      for (const Json& name : shape["not_told_apart"])
        names += (names.empty() ? "" : " + ") + name.get<std::string>();
      std::printf("    only the sum of these is known, %.1f %%: %s\n", percent, names.c_str());
      continue;
    }
    char sd[32] = "";
    if (shape["sd"].is_number()) std::snprintf(sd, sizeof sd, "+- %.3f", shape["sd"].get<double>());
    std::printf("    %-18s %12.3f  %-11s %-5s %6.1f %% %11.1f\n", shape["name"].get<std::string>().c_str(),
                shape["value"].get<double>(), sd, shape["unit"].get<std::string>().c_str(), percent,
                shape["without_um"].get<double>());
  }
}

void print_signatures(const Json& run) {
  const Json plane = run.value("signatures", Json::array());
  const Json radial = run.value("radial_signatures", Json::array());
  if (plane.empty()) return;
  std::printf(
      "  Shapes in both directions together, by share of their circular error. On a robot they are shapes, "
      "not "
      "causes: it has\n  no X and Y slides, and 'backlash_x' says where the trace steps, not which part has "
      "play.\n");
  std::printf("  in the plane's own frame\n");
  print_shapes(plane);
  if (radial.empty()) return;
  std::printf("  X along the radius from the base's axis, %.1f degrees from the plane's first axis\n",
              run["radial_frame_deg"].get<double>());
  print_shapes(radial);
}

int show(const ShowOptions& options) {
  const StoredRun run = find_run(options.where.open(), options.run);
  const Json json = to_json(run);
  if (options.json) {
    std::cout << text_of(json);
    return 0;
  }
  std::printf("run %lld: %s %s, series '%s', begun %s UTC\n", static_cast<long long>(run.id),
              run.robot.c_str(), run_name(run.test, run.direction, run.repetition).c_str(),
              run.series.c_str(), utc_text(run.started_us).c_str());
  std::printf("  status %s%s%s\n", run.status.c_str(), run.message.empty() ? "" : ": ", run.message.c_str());
  if (run.source == kVirtualSource) std::printf("  virtual ballbar: readings are those of the joints\n");
  if (run.end == RunEnd::kGeometry)
    std::printf("  recognised by the circle that was driven: there were no marks\n");
  if (!run.plane.empty()) std::printf("  plane %s\n", run.plane.c_str());
  if (!run.angle_source.empty()) std::printf("  angles from %s\n", run.angle_source.c_str());
  if (!run.predicted_from.empty()) std::printf("  predicted from the %s\n", run.predicted_from.c_str());
  for (const Record& record : run.records) {
    if (!record.axis.empty()) std::printf("  axis %s\n", record.axis.c_str());
    print_figures(record);
  }
  print_harmonics(json);
  print_signatures(json);
  return 0;
}

}  // namespace

void add_show(CLI::App& app, Action& action) {
  auto options = std::make_shared<ShowOptions>();
  CLI::App* list_verb = app.add_subcommand("list", "the runs of the database, oldest first");
  options->where.add_to(*list_verb);
  options->choice.add_to(*list_verb);
  list_verb->add_flag("--json", options->json, "as JSON");
  list_verb->callback([options, &action] { action = [options] { return list(*options); }; });

  auto show_options = std::make_shared<ShowOptions>();
  CLI::App* show_verb = app.add_subcommand("show", "all figures of one run");
  show_verb->add_option("RUN", show_options->run, "its id, or its name: A+1#2 or SERIES:A+1#2")->required();
  show_options->where.add_to(*show_verb);
  show_verb->add_flag("--json", show_options->json, "as JSON");
  show_verb->callback([show_options, &action] { action = [show_options] { return show(*show_options); }; });
}

}  // namespace ballbar

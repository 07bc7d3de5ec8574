// The way of a run from messages to the database, where something is missing on it.

#include "daemon/service.hpp"

#include <gtest/gtest.h>

#include "bus/assembler.hpp"
#include "support/circle_feed.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

/// A service without rules, and one robot whose circles it hears.
class Listening {
 public:
  Listening() : store_(dir_.path() + "/b.db") {
    test::write_file(dir_.path() + "/b.toml",
                     "[rules]\ndirectory = \"none\"\n" + test::planar_robot(dir_.path()));
    const Config config = load_config(dir_.path() + "/b.toml");
    assembler_.emplace(config.robots);
    service_.emplace(config, load_models(config), RuleSet(), store_,
                     [this](Priority, const std::string& line) { said += line + "\n"; });
  }

  /// Circle `number` of the feed, its bar's messages lost or not.
  void hear(std::int64_t number, bool bar) {
    std::vector<Run> finished;
    const std::int64_t at_us = test::CircleFeed::started_us(number);
    for (const Sample& sample : feed_.samples(number))
      if (bar || !std::holds_alternative<BallbarBlock>(sample)) assembler_->take(sample, at_us, finished);
    assembler_->tick(at_us + test::CircleFeed::kEveryUs, finished);
    for (Run& run : finished) service_->on_run(std::move(run));
  }

  std::vector<std::string> statuses() const {
    std::vector<std::string> all;
    for (const StoredRun& run : store_.runs())
      all.push_back(run.status + " " + run.source + " " + std::to_string(run.lost_messages));
    return all;
  }
  std::int64_t lost() const { return assembler_->counters().lost_messages; }

  std::string said;

 private:
  test::TempDir dir_;
  Store store_;
  test::CircleFeed feed_;
  std::optional<Assembler> assembler_;
  std::optional<Service> service_;
};

using Statuses = std::vector<std::string>;

TEST(Service, ABarWhoseCableIsOutIsMissedUntilItIsBack) {
  Listening cell;
  cell.hear(1, true);
  cell.hear(2, false);
  cell.hear(3, false);
  EXPECT_NE(cell.said.find("planar A+1#3 (s): no_bar, virtual ballbar"), std::string::npos) << cell.said;
  cell.hear(4, true);
  EXPECT_EQ(cell.statuses(), (Statuses{"ok bar 0", "no_bar joints 0", "no_bar joints 0", "ok bar 0"}));
  EXPECT_EQ(cell.lost(), 18) << "nine blocks of 50 samples are a circle of 16.8 s at 25 Hz";
}

TEST(Service, ACellWithoutABarMissesNone) {
  Listening cell;
  for (int number = 1; number < 4; ++number) cell.hear(number, false);
  EXPECT_EQ(cell.statuses(), (Statuses{"ok joints 0", "ok joints 0", "ok joints 0"}));
}

}  // namespace
}  // namespace ballbar

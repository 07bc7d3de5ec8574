/// Which runs of a database one diagnosis takes.

#include "daemon/series_diagnosis.hpp"

#include <gtest/gtest.h>

#include "store/example_runs.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kMinuteUs = 60'000'000;
constexpr std::int64_t kHourUs = 60 * kMinuteUs;

class LatestMeasurement : public testing::Test {
 protected:
  void add(std::int64_t started_us, const std::string& series) {
    test::Saved s = test::circle(started_us);
    s.run.series = series;
    s.result.source = "bar";
    s.result.angle_source = "joints";
    for (Record& record : s.records) record.series = series;
    store.save(s.run, s.result, s.records, {}, {});
  }
  std::vector<std::int64_t> begins(const std::string& series, std::int64_t apart_us = kSameMeasurementUs) {
    std::vector<std::int64_t> found;
    for (const StoredRun& run : latest_measurement(store, "lrmate-1", series, apart_us))
      found.push_back(run.started_us);
    return found;
  }
  test::TempDir dir;
  Store store{dir.path() + "/a.db"};
};

TEST_F(LatestMeasurement, GoesBackToWhereNothingWasHeardForHalfADay) {
  add(0, "s");
  add(kHourUs, "s");
  add(14 * kHourUs, "s");
  add(15 * kHourUs, "s-held-out");
  add(16 * kHourUs, "other");
  add(25 * kHourUs, "s");
  EXPECT_EQ(begins("s"), (std::vector<std::int64_t>{14 * kHourUs, 15 * kHourUs, 25 * kHourUs}));
  EXPECT_EQ(begins("other"), (std::vector<std::int64_t>{16 * kHourUs}));
  EXPECT_EQ(begins("none"), (std::vector<std::int64_t>{}));
  EXPECT_EQ(begins("s", INT64_MAX).size(), 5u);
}

TEST_F(LatestMeasurement, OfARobotThatNeverRestsIsBounded) {
  const auto most = static_cast<std::int64_t>(kMostRunsOfMeasurement);
  for (std::int64_t i = 0; i < most + 150; ++i) add(i * 5 * kMinuteUs, "");
  const std::vector<std::int64_t> found = begins("");
  ASSERT_EQ(found.size(), kMostRunsOfMeasurement);
  EXPECT_EQ(found.front(), 150 * 5 * kMinuteUs);
  EXPECT_EQ(found.back(), (most + 149) * 5 * kMinuteUs);
}

}  // namespace
}  // namespace ballbar

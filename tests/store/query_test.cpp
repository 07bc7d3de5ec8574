/// History for rules, partners of lines, and lists of runs.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "store/example_runs.hpp"
#include "store/store.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

class QueryTest : public testing::Test {
 protected:
  std::int64_t put(const test::Saved& s) { return store.save(s.run, s.result, s.records, {}, {}); }

  /// A circle at minute `minute`; `change` makes it differ.
  template <class Change>
  std::int64_t put_circle(int minute, Change change) {
    test::Saved s = test::circle(at(minute), static_cast<unsigned>(minute));
    change(s);
    const std::map<std::string, Estimate> values = s.records[0].values;
    s.records[0] = test::labels_of(s);
    s.records[0].values = values;
    return put(s);
  }
  std::int64_t put_circle(int minute) {
    return put_circle(minute, [](test::Saved&) {});
  }
  static std::int64_t at(int minute) { return test::kDay + minute * 60'000'000LL; }
  template <class Result>
  static std::vector<int> minutes(const std::vector<Result>& results) {
    std::vector<int> all(results.size());
    std::transform(results.begin(), results.end(), all.begin(), [](const Result& r) {
      return static_cast<int>((r.started_us - test::kDay) / 60'000'000);
    });
    return all;
  }
  using Minutes = std::vector<int>;
  Minutes seen(const Record& like, const std::string& which) {
    return minutes(store.past(like)->window(which));
  }

  test::TempDir dir;
  Store store{dir.path() + "/b.db"};
};

TEST_F(QueryTest, HistoryHoldsOnlyEarlierGoodResultsOfTheSameRobotTestAndDirection) {
  put_circle(1);
  put_circle(2, [](test::Saved& s) { s.run.robot = "lrmate-2"; });
  put_circle(3, [](test::Saved& s) { s.run.test = "B"; });
  put_circle(4, [](test::Saved& s) { s.run.direction = -1; });
  put_circle(5, [](test::Saved& s) { s.result.status = "arc_incomplete"; });
  put_circle(6, [](test::Saved& s) { s.run.series = "after"; });
  put_circle(7);
  put_circle(10, [](test::Saved& s) { s.result.source = "joints"; });
  put_circle(8);  // the one being judged may be stored already
  put_circle(9);  // later, e.g. in a backtest

  Record like = test::circle(at(8)).records[0];
  EXPECT_EQ(seen(like, "series"), (Minutes{1, 7}));
  EXPECT_EQ(seen(like, "recent"), (Minutes{1, 6, 7}));
  EXPECT_EQ(seen(like, "first"), (Minutes{1, 6, 7}));
  EXPECT_EQ(seen(like, "series after"), (Minutes{6}));

  // A bar and the joints measure different things: neither is the other's past.
  like.started_us = at(11);
  EXPECT_EQ(seen(like, "recent"), (Minutes{1, 6, 7, 8, 9}));
  like.source = "joints";
  EXPECT_EQ(seen(like, "recent"), (Minutes{10}));
}

TEST_F(QueryTest, HistoryKeepsTheFirstOfTheSeriesAndTheLatestOfAll) {
  constexpr int kMany = static_cast<int>(kPastRecent) + 30;
  for (int minute = kMany; minute >= 0; --minute)  // stored in any order
    put_circle(minute);
  const Record like = test::circle(at(kMany)).records[0];
  const Minutes first = seen(like, "series");
  const Minutes recent = seen(like, "recent");
  ASSERT_EQ(first.size(), kPastFirst);
  ASSERT_EQ(recent.size(), kPastRecent);
  EXPECT_EQ(first.front(), 0);
  EXPECT_EQ(first.back(), static_cast<int>(kPastFirst) - 1);
  EXPECT_EQ(recent.front(), kMany - static_cast<int>(kPastRecent));
  EXPECT_EQ(recent.back(), kMany - 1);
}

TEST_F(QueryTest, ACalibrationBeginsANewBaselineOfItsRobotAndTest) {
  for (int minute = 1; minute <= 6; ++minute) put_circle(minute);
  store.set_baseline({"lrmate-2", "", at(5), "another robot"});
  store.set_baseline({"lrmate-1", "B", at(5), "another test"});
  EXPECT_EQ(seen(test::circle(at(7)).records[0], "calibration"), (Minutes{1, 2, 3, 4, 5, 6}));
  store.set_baseline({"lrmate-1", "", at(3), "mastered"});
  store.set_baseline({"lrmate-1", "", at(3), "the same mark, sent twice"});
  EXPECT_EQ(seen(test::circle(at(7)).records[0], "calibration"), (Minutes{3, 4, 5, 6}));
  EXPECT_EQ(seen(test::circle(at(2)).records[0], "calibration"), (Minutes{1})) << "as it was at that time";
  store.set_baseline({"lrmate-1", "A", at(5), "new ball"});
  EXPECT_EQ(seen(test::circle(at(7)).records[0], "calibration"), (Minutes{5, 6}));
  EXPECT_EQ(store.baselines().size(), 4u);
}

TEST_F(QueryTest, BothDirectionsAreAPastOfTheirOwn) {
  const auto both = [](test::Saved& s) { s.records[0].values["positional_tolerance_um"] = {7.0, {}}; };
  put_circle(1);
  put_circle(2, [&](test::Saved& s) { s.run.direction = -1, both(s); });
  put_circle(3, [](test::Saved& s) { s.run.direction = -1; });
  put_circle(4, both);
  put_circle(5, [&](test::Saved& s) { s.run.series = "after", both(s); });
  Record like = test::circle(at(6)).records[0];
  like.kind = "test";
  like.direction = 0;
  EXPECT_EQ(seen(like, "recent"), (Minutes{2, 4, 5}));
  EXPECT_EQ(seen(like, "series"), (Minutes{2, 4}));
  EXPECT_EQ(store.past(like)->column("recent", "positional_tolerance_um"), std::vector<double>(3, 7.0));
}

TEST_F(QueryTest, HistoryIsWhatWasSavedSignaturesAndHarmonicsToo) {
  const test::Saved s = test::circle(at(1), 42);
  put(s);
  const std::unique_ptr<Past> past = store.past(test::circle(at(2)).records[0]);
  const auto value = [&](const std::string& name) { return past->column("recent", name).at(0); };
  for (int k = 1; k <= 10; ++k) {
    const Harmonic& truth = s.result.circle->harmonics[static_cast<std::size_t>(k - 1)];
    const std::string name = "harmonic" + std::to_string(k);
    EXPECT_DOUBLE_EQ(value(name + "_cos_um"), truth.cos * 1e6);
    EXPECT_DOUBLE_EQ(value(name + "_sin_um"), truth.sin * 1e6);
    EXPECT_DOUBLE_EQ(value(name + "_um"), std::hypot(truth.cos, truth.sin) * 1e6);
    const Harmonic& gap = s.result.circle_gap->harmonics[static_cast<std::size_t>(k - 1)];
    EXPECT_DOUBLE_EQ(value("gap_" + name + "_sin_um"), gap.sin * 1e6);
  }
  const std::vector<Signature>& saved = s.result.circle_test->signatures->signatures;
  EXPECT_DOUBLE_EQ(value("signature_backlash_x_um"), saved[0].value.value() * 1e6);
  EXPECT_DOUBLE_EQ(value("signature_squareness_um_per_m"), saved[1].value.value() * 1e6);
  EXPECT_DOUBLE_EQ(value("radial_signature_backlash_x_um"),
                   s.result.circle_test->radial_signatures->signatures[0].value.value() * 1e6);
  for (const auto& [name, estimate] : s.records[0].values)
    EXPECT_DOUBLE_EQ(value(name), estimate.value) << name;
  EXPECT_TRUE(std::isnan(value("hysteresis_um"))) << "what it does not have";
  Record label = past->window("recent").at(0);
  label.values = s.records[0].values;
  EXPECT_EQ(label, s.records[0]);
}

TEST_F(QueryTest, StandardDeviationOfAnAmplitudeIsThatOfManyDraws) {
  const test::Saved s = test::circle(at(1), 42);
  put(s);
  RunFilter all;
  all.harmonic_orders = 2;
  const Record record = store.runs(all).at(0).records.at(0);
  const Harmonic& h = s.result.circle->harmonics[1];
  std::mt19937_64 rng(7);
  std::normal_distribution<double> unit;
  double sum = 0.0, squares = 0.0;
  constexpr int kDraws = 20'000;
  for (int i = 0; i < kDraws; ++i) {  // by Cholesky of the 2x2 covariance
    const double a = std::sqrt(h.var_cos), b = h.cov_cos_sin / a, u = unit(rng);
    const double amplitude =
        std::hypot(h.cos + a * u, h.sin + b * u + std::sqrt(h.var_sin - b * b) * unit(rng));
    sum += amplitude;
    squares += amplitude * amplitude;
  }
  const double mean = sum / kDraws;
  const double sd_um = std::sqrt(squares / kDraws - mean * mean) * 1e6;
  EXPECT_NEAR(*record.values.at("harmonic2_um").sd, sd_um, 0.03 * sd_um);  // 20 000 draws give 0.5 %
}

TEST_F(QueryTest, HistoryOfALineIsThatOfItsAxis) {
  put(test::line(at(1)));
  test::Saved only_x = test::line(at(2));
  only_x.result.lines.pop_back();
  only_x.records.pop_back();
  put(only_x);
  put(test::line(at(3), -1));
  const test::Saved now = test::line(at(4));
  EXPECT_EQ(seen(now.records[0], "recent"), (Minutes{1, 2}));
  EXPECT_EQ(seen(now.records[1], "recent"), (Minutes{1}));
  EXPECT_DOUBLE_EQ(store.past(now.records[1])->column("recent", "straightness_mz_um").at(0),
                   test::line(at(1)).records.at(1).values.at("straightness_mz_um").value);
}

TEST_F(QueryTest, LinePartnerIsTheLatestRunTheOtherWayAndRatherOfTheSameRepetition) {
  const auto put_line = [this](int minute, int direction, int repetition,
                               const std::string& series = "before", const std::string& status = "ok") {
    test::Saved s = test::line(at(minute), direction, static_cast<unsigned>(minute));
    s.run.repetition = repetition;
    s.run.series = series;
    s.result.status = status;
    s.records.clear();
    put(s);
    return s.result.lines[0].points[0].deviation;
  };
  const auto partner = [this](int minute, int direction, int repetition) {
    const AxisPoints found = store.line_partner("lrmate-1", "Y", "before", direction, repetition, at(minute));
    return found.empty() ? 0.0 : found[0].second[0].deviation;
  };
  EXPECT_EQ(partner(10, -1, 1), 0.0);  // nothing stored
  const double first = put_line(1, 1, 1);
  const double second = put_line(2, 1, 2);
  put_line(3, -1, 1);                     // the same way
  put_line(4, 1, 1, "after");             // another series
  put_line(5, 1, 1, "before", "no_end");  // not good
  EXPECT_NEAR(partner(10, -1, 1), first, 1e-18);
  EXPECT_NEAR(partner(10, -1, 2), second, 1e-18);
  EXPECT_NEAR(partner(10, -1, 3), second, 1e-18);  // no such repetition: the latest
  EXPECT_NEAR(partner(2, -1, 2), first, 1e-18);    // only earlier ones
  EXPECT_EQ(partner(10, 0, 1), 0.0);               // direction not known: no other way
  const AxisPoints both = store.line_partner("lrmate-1", "Y", "before", -1, 1, at(10));
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].first, 'X');
  EXPECT_EQ(both[1].first, 'Z');
  EXPECT_EQ(both[1].second.size(), 21u);
}

TEST_F(QueryTest, CirclePartnerIsTheSameRepetitionTheOtherWayAndJoinsOnce) {
  struct Case {
    const char* what;
    std::function<void(test::Saved&)> change;
    bool fits;
  };
  const std::vector<Case> cases{
      {"the other way", [](test::Saved&) {}, true},
      {"the same way", [](test::Saved& s) { s.run.direction = -1; }, false},
      {"no direction", [](test::Saved& s) { s.run.direction = 0; }, false},
      {"another repetition", [](test::Saved& s) { s.run.repetition = 2; }, false},
      {"another series", [](test::Saved& s) { s.run.series = "after"; }, false},
      {"another test", [](test::Saved& s) { s.run.test = "B"; }, false},
      {"another robot", [](test::Saved& s) { s.run.robot = "lrmate-2"; }, false},
      {"a virtual bar", [](test::Saved& s) { s.result.source = "joints"; }, false},
      {"not good", [](test::Saved& s) { s.result.status = "arc_incomplete"; }, false},
      {"another feed", [](test::Saved& s) { s.run.feed *= 1.02; }, false},
      {"nearly the feed", [](test::Saved& s) { s.run.feed *= 1.005; }, true},
      {"joined already",
       [](test::Saved& s) {
         s.records[0].values["hysteresis_um"] = {3.0, {}};
       },
       false},
  };
  test::Saved now = test::circle(at(200));
  now.run.direction = -1;
  for (const Case& c : cases) {
    EXPECT_FALSE(store.circle_partner(now.run, "bar")) << c.what;
    const std::int64_t id = put_circle(1, c.change);
    const std::optional<CirclePartner> found = store.circle_partner(now.run, "bar");
    ASSERT_EQ(found.has_value(), c.fits) << c.what;
    if (found) {
      EXPECT_EQ(found->id, id);
      EXPECT_EQ(found->direction, 1);
      EXPECT_EQ(found->temperature, 22.5);
      EXPECT_EQ(found->trace.bar_deviation.size(), 300u);
      EXPECT_EQ(found->trace.arc_begin, 10u);
    }
    store.database().execute("DELETE FROM run");
  }
  put_circle(1);
  const std::int64_t latest = put_circle(2);
  put_circle(201);  // later
  EXPECT_EQ(store.circle_partner(now.run, "bar")->id, latest);
  store.database().execute("UPDATE trace SET bytes = x'00'");
  EXPECT_FALSE(store.circle_partner(now.run, "bar")) << "what cannot be read is no partner, and no failure";
}

TEST_F(QueryTest, CirclePartnerInASeriesWithoutNameIsOfTheHourBefore) {
  const auto without_name = [](test::Saved& s) { s.run.series.clear(); };
  put_circle(0, without_name);
  test::Saved now = test::circle(at(60));
  now.run.series.clear();
  now.run.direction = -1;
  EXPECT_TRUE(store.circle_partner(now.run, "bar"));
  now.run.started_us += 1;
  EXPECT_FALSE(store.circle_partner(now.run, "bar"));
}

TEST_F(QueryTest, SourceBeforeIsThatOfTheLatestGoodCircleOfTheSeries) {
  constexpr int kHour = 60, kDay = 24 * kHour;  // minutes
  test::Saved now = test::circle(at(2 * kDay));
  struct Before {
    int minute;
    const char *test, *series, *source, *status;
  };
  struct Case {
    const char *what, *series;
    std::vector<Before> before;
    const char* source;
  };
  const std::vector<Case> cases{
      {"nothing", "s", {}, ""},
      {"the latest",
       "s",
       {{2 * kDay - 3, "A", "s", "bar", "ok"}, {2 * kDay - 2, "A", "s", "joints", "ok"}},
       "joints"},
      {"a good one",
       "s",
       {{2 * kDay - 3, "A", "s", "bar", "ok"}, {2 * kDay - 2, "A", "s", "joints", "no_bar"}},
       "bar"},
      {"another series", "s", {{2 * kDay - 3, "A", "t", "bar", "ok"}}, ""},
      {"another test", "s", {{2 * kDay - 3, "B", "s", "bar", "ok"}}, "bar"},
      {"the same test rather",
       "s",
       {{2 * kDay - 3, "A", "s", "joints", "ok"}, {2 * kDay - 2, "B", "s", "bar", "ok"}},
       "joints"},
      {"a day", "s", {{kDay, "A", "s", "bar", "ok"}}, "bar"},
      {"more", "s", {{kDay - 1, "A", "s", "bar", "ok"}}, ""},
      {"an hour", "", {{2 * kDay - kHour, "A", "", "bar", "ok"}}, "bar"},
      {"more, without name", "", {{2 * kDay - kHour - 1, "A", "", "bar", "ok"}}, ""},
      {"later", "s", {{2 * kDay, "A", "s", "bar", "ok"}}, ""},
  };
  for (const Case& c : cases) {
    store.database().execute("DELETE FROM run");
    for (const Before& b : c.before)
      put_circle(b.minute, [&](test::Saved& s) {
        s.run.test = b.test;
        s.run.series = b.series;
        s.result.source = b.source;
        s.result.status = b.status;
      });
    now.run.series = c.series;
    EXPECT_EQ(store.source_before(now.run), c.source) << c.what;
  }
  put_circle(2 * kDay - 1, [](test::Saved& s) { s.run.series.clear(); });
  now.run.series.clear();
  now.run.robot = "lrmate-2";
  EXPECT_EQ(store.source_before(now.run), "") << "another robot";
}

TEST_F(QueryTest, ListsRunsByBeginAndFilters) {
  const std::int64_t third = put_circle(3);
  put_circle(1, [](test::Saved& s) { s.run.direction = -1; });
  put_circle(2, [](test::Saved& s) { s.run.series = "after"; });
  put_circle(4, [](test::Saved& s) { s.result.status = "no_end"; });
  const std::int64_t line = put(test::line(at(5)));
  const auto list = [this](auto change) {
    RunFilter f;
    change(f);
    return minutes(store.runs(f));
  };
  EXPECT_EQ(list([](RunFilter&) {}), (Minutes{1, 2, 3, 4, 5}));
  EXPECT_EQ(list([&](RunFilter& f) { f.ids = {line, third}; }), (Minutes{3, 5}));
  EXPECT_EQ(list([](RunFilter& f) { f.ids = {99}; }), (Minutes{}));
  EXPECT_EQ(list([](RunFilter& f) { f.direction = -1; }), (Minutes{1}));
  EXPECT_EQ(list([](RunFilter& f) { f.series = "after"; }), (Minutes{2}));
  EXPECT_EQ(list([](RunFilter& f) { f.series = ""; }), (Minutes{}));  // a series without name is one, too
  EXPECT_EQ(list([](RunFilter& f) { f.status = "no_end"; }), (Minutes{4}));
  EXPECT_EQ(list([](RunFilter& f) { f.kind = TestKind::kLine; }), (Minutes{5}));
  EXPECT_EQ(list([](RunFilter& f) { f.test = "A"; }), (Minutes{1, 2, 3, 4}));
  EXPECT_EQ(list([](RunFilter& f) { f.robot = "other"; }), (Minutes{}));
  EXPECT_EQ(list([](RunFilter& f) {
              f.since_us = at(2);
              f.until_us = at(4);
            }),
            (Minutes{2, 3}));
  EXPECT_EQ(list([](RunFilter& f) { f.limit = 2; }), (Minutes{1, 2}));
  EXPECT_EQ(list([](RunFilter& f) {
              f.limit = 2;
              f.newest_first = true;
            }),
            (Minutes{5, 4}));
  RunFilter harmonics;
  harmonics.harmonic_orders = 2;
  harmonics.ids = {third};
  const Record record = store.runs(harmonics).at(0).records.at(0);
  EXPECT_EQ(record.values.count("harmonic2_um"), 1u);
  EXPECT_EQ(record.values.count("harmonic3_um"), 0u);
}

}  // namespace
}  // namespace ballbar

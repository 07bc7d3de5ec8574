#include "rules/lua_questions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <lua.hpp>

#include "numerics/hotelling.hpp"
#include "numerics/statistics.hpp"
#include "numerics/trend.hpp"
#include "rules/lua_record.hpp"
#include "rules/names.hpp"
#include "rules/sandbox_library.hpp"

namespace ballbar {
namespace {

using Eigen::Vector2d;
using Values = std::vector<double>;

constexpr double kUsPerDay = 86'400e6;
// Instructions that a question about two hundred figures is worth; slopes cost five times that.
constexpr long long kQuestionCost = 2000;
constexpr int kMostSlopes = 100;  // results of a slope: their pairs are what takes time

// Calls `read`; what the store throws waits until the script has ended.
template <typename Read>
auto guarded(lua_State* lua, Asked& asked, Read read) {
  try {
    return read();
  } catch (const std::exception& error) {
    asked.failed = std::current_exception();
  }
  luaL_error(lua, "the history cannot be read");
  std::abort();  // not reached: luaL_error does not return
}

}  // namespace

const std::vector<double>& column(lua_State* lua, Asked& asked, const std::string& window,
                                  const std::string& name) {
  return *guarded(lua, asked, [&] { return &asked.past.column(window, name); });
}

const std::vector<Record>& labels(lua_State* lua, Asked& asked, const std::string& window) {
  return *guarded(lua, asked, [&] { return &asked.past.window(window); });
}

namespace {

Asked& asked_of(lua_State* lua) { return *static_cast<Asked*>(lua_touserdata(lua, lua_upvalueindex(1))); }

std::string name_argument(lua_State* lua, const Asked& asked) {
  std::string name = luaL_checkstring(lua, 1);
  if (!is_quantity_of(name, asked.record.kind)) refuse_unknown_name(lua, name, asked.record.kind);
  return name;
}

double present(lua_State* lua, const Asked& asked, const std::string& name) {
  const auto found = asked.record.values.find(name);
  if (found == asked.record.values.end() || !std::isfinite(found->second.value))
    luaL_error(lua, "this %s has no '%s'", asked.record.kind.c_str(), name.c_str());
  return found->second.value;
}

std::size_t count_argument(lua_State* lua, int index, int otherwise, int least, int most) {
  const lua_Integer number = luaL_optinteger(lua, index, otherwise);
  if (number < least || number > most) luaL_error(lua, "so many results must be from %d to %d", least, most);
  return static_cast<std::size_t>(number);
}

double positive_argument(lua_State* lua, int index, double otherwise, double most) {
  const double number = luaL_optnumber(lua, index, otherwise);
  if (!(number > 0.0 && number <= most))
    luaL_error(lua, "argument %d must be more than 0 and at most %f", index, most);
  return number;
}

int nothing(lua_State* lua) {
  lua_pushnil(lua);
  return 1;
}

int answer(lua_State* lua, std::initializer_list<double> numbers) {
  for (const double number : numbers) lua_pushnumber(lua, number);
  return static_cast<int>(numbers.size());
}

// The latest `most` earlier values, oldest first.
Values latest(lua_State* lua, Asked& asked, const std::string& name, std::size_t most) {
  charge(lua, kQuestionCost);
  Values values;
  for (const double v : column(lua, asked, "recent", name))
    if (std::isfinite(v)) values.push_back(v);
  if (values.size() > most) values.erase(values.begin(), values.end() - static_cast<std::ptrdiff_t>(most));
  return values;
}

int count(lua_State* lua) {
  Asked& asked = asked_of(lua);
  lua_pushinteger(
      lua, static_cast<lua_Integer>(latest(lua, asked, name_argument(lua, asked), kPastRecent).size()));
  return 1;
}

int last(lua_State* lua) {
  Asked& asked = asked_of(lua);
  const std::size_t back = count_argument(lua, 2, 1, 1, kPastRecent);
  const Values values = latest(lua, asked, name_argument(lua, asked), back);
  return values.size() < back ? nothing(lua) : answer(lua, {values.front()});
}

// Of the latest n, from `least` on.
template <typename Figure>
int figure_of_latest(lua_State* lua, std::size_t least, Figure figure) {
  Asked& asked = asked_of(lua);
  const std::size_t most = count_argument(lua, 2, 20, static_cast<int>(least), kPastRecent);
  const Values values = latest(lua, asked, name_argument(lua, asked), most);
  return values.size() < least ? nothing(lua) : answer(lua, {figure(values)});
}

int mean_of_latest(lua_State* lua) {
  return figure_of_latest(lua, 2, [](const Values& v) { return mean(v); });
}
int median_of_latest(lua_State* lua) {
  return figure_of_latest(lua, 3, [](const Values& v) { return median(v); });
}
int spread_of_latest(lua_State* lua) {
  return figure_of_latest(lua, 5, [](const Values& v) { return median_spread(v); });
}

// Theil-Sen over the latest n and the present one, in days from the present.
std::optional<RobustSlope> slope_of(lua_State* lua, Asked& asked, const std::string& name, int argument) {
  const std::size_t most = count_argument(lua, argument, 30, 5, kMostSlopes);
  charge(lua, 5 * kQuestionCost);
  const Values& all = column(lua, asked, "recent", name);
  const std::vector<Record>& when = labels(lua, asked, "recent");
  Values days{0.0};
  Values values{present(lua, asked, name)};
  for (std::size_t i = all.size(); i-- > 0 && values.size() < most;) {
    if (!std::isfinite(all[i])) continue;
    days.push_back(static_cast<double>(when[i].started_us - asked.record.started_us) / kUsPerDay);
    values.push_back(all[i]);
  }
  return theil_sen(days, values);
}

int slope(lua_State* lua) {
  Asked& asked = asked_of(lua);
  const auto fit = slope_of(lua, asked, name_argument(lua, asked), 2);
  return fit ? answer(lua, {fit->slope, fit->low, fit->high}) : nothing(lua);
}

int days_until(lua_State* lua) {
  Asked& asked = asked_of(lua);
  const double limit = luaL_checknumber(lua, 2);
  const auto fit = slope_of(lua, asked, name_argument(lua, asked), 3);
  if (!fit) return nothing(lua);
  const double away = limit - fit->intercept;
  const bool nears = away > 0.0 ? fit->low > 0.0 : fit->high < 0.0;
  return answer(lua, {nears ? away / fit->slope : HUGE_VAL});
}

int percent(lua_State* lua) {
  Asked& asked = asked_of(lua);
  const double limit = luaL_checknumber(lua, 2);
  if (!(limit > 0.0)) return luaL_error(lua, "the limit must be more than 0");
  return answer(lua, {100.0 * std::abs(present(lua, asked, name_argument(lua, asked))) / limit});
}

// The baseline's first runs that hold all of `names`, as indices into its window; empty until it is complete.
std::vector<std::size_t> baseline_places(lua_State* lua, Asked& asked,
                                         const std::vector<std::string>& names) {
  charge(lua, kQuestionCost);
  const auto wanted = static_cast<std::size_t>(asked.rule.baseline_runs);
  const std::size_t held = labels(lua, asked, asked.rule.baseline).size();
  std::vector<const Values*> columns;
  columns.reserve(names.size());
  for (const std::string& name : names) columns.push_back(&column(lua, asked, asked.rule.baseline, name));
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < held && places.size() < wanted; ++i) {
    if (std::all_of(columns.begin(), columns.end(), [&](const Values* c) { return std::isfinite((*c)[i]); }))
      places.push_back(i);
  }
  if (places.size() < wanted) places.clear();
  return places;
}

// The recent results that began after the baseline's last. A series is its own baseline's only.
std::vector<std::size_t> places_since(lua_State* lua, Asked& asked,
                                      const std::vector<std::size_t>& baseline) {
  const std::int64_t end_us = labels(lua, asked, asked.rule.baseline)[baseline.back()].started_us;
  const bool one_series = asked.rule.baseline == "series";
  const std::vector<Record>& recent = labels(lua, asked, "recent");
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < recent.size(); ++i)
    if (recent[i].started_us > end_us && (!one_series || recent[i].series == asked.record.series))
      places.push_back(i);
  return places;
}

struct Watched {
  Values baseline;
  Values since;  // with the present one
};

std::optional<Watched> watch(lua_State* lua, Asked& asked, const std::string& name) {
  const std::vector<std::size_t> places = baseline_places(lua, asked, {name});
  const double now = present(lua, asked, name);
  if (places.empty()) return std::nullopt;
  Watched watched;
  for (const std::size_t i : places)
    watched.baseline.push_back(column(lua, asked, asked.rule.baseline, name)[i]);
  const Values& recent = column(lua, asked, "recent", name);
  for (const std::size_t i : places_since(lua, asked, places))
    if (std::isfinite(recent[i])) watched.since.push_back(recent[i]);
  watched.since.push_back(now);
  return watched;
}

int baseline(lua_State* lua) {
  Asked& asked = asked_of(lua);
  const auto watched = watch(lua, asked, name_argument(lua, asked));
  if (!watched) return nothing(lua);
  return answer(lua, {mean(watched->baseline), sample_sd(watched->baseline).value_or(0.0),
                      static_cast<double>(watched->baseline.size())});
}

int ewma_since_baseline(lua_State* lua) {
  Asked& asked = asked_of(lua);
  const double weight = positive_argument(lua, 2, 0.2, 1.0);
  const auto watched = watch(lua, asked, name_argument(lua, asked));
  const double sd = watched ? sample_sd(watched->baseline).value_or(0.0) : 0.0;
  if (!(sd > 0.0)) return nothing(lua);
  const auto [level, distance] = ewma(watched->since, mean(watched->baseline), sd, weight);
  return answer(lua, {level, distance});
}

int cusum_since_baseline(lua_State* lua) {
  Asked& asked = asked_of(lua);
  const double allowance = positive_argument(lua, 2, 1.5, 100.0);
  const auto watched = watch(lua, asked, name_argument(lua, asked));
  const double sd = watched ? sample_sd(watched->baseline).value_or(0.0) : 0.0;
  if (!(sd > 0.0)) return nothing(lua);
  const auto [up, down] = cusum(watched->since, mean(watched->baseline), sd, allowance);
  return answer(lua, {up, down});
}

struct WatchedVectors {
  std::vector<Vector2d> baseline;
  std::vector<Vector2d> since;  // with the present one
  VectorSample sample;
};

std::optional<WatchedVectors> watch_vectors(lua_State* lua, Asked& asked) {
  const std::string vector = luaL_checkstring(lua, 1);
  const std::string cos = vector + "_cos_um";
  const std::string sin = vector + "_sin_um";
  if (!is_quantity_of(cos, asked.record.kind))
    luaL_error(lua, "'%s' is no vector of a %s: \"ovality\", \"harmonic3\", \"gap_harmonic2\" ...",
               vector.c_str(), asked.record.kind.c_str());
  const std::vector<std::size_t> places = baseline_places(lua, asked, {cos, sin});
  const Vector2d now(present(lua, asked, cos), present(lua, asked, sin));
  if (places.empty()) return std::nullopt;
  WatchedVectors watched;
  for (const std::size_t i : places)
    watched.baseline.emplace_back(column(lua, asked, asked.rule.baseline, cos)[i],
                                  column(lua, asked, asked.rule.baseline, sin)[i]);
  const Values& x = column(lua, asked, "recent", cos);
  const Values& y = column(lua, asked, "recent", sin);
  for (const std::size_t i : places_since(lua, asked, places))
    if (std::isfinite(x[i]) && std::isfinite(y[i])) watched.since.emplace_back(x[i], y[i]);
  watched.since.push_back(now);
  watched.sample = sample_of(watched.baseline);
  constexpr double kFlat = 1e-12;  // as in hotelling.cpp: rounding
  const Eigen::Matrix2d covariance = watched.sample.covariance.value_or(Eigen::Matrix2d::Zero());
  const double size = covariance.trace();
  if (!(covariance(0, 0) * covariance(1, 1) - covariance(0, 1) * covariance(1, 0) > kFlat * size * size))
    return std::nullopt;
  return watched;
}

int distance(lua_State* lua) {
  Asked& asked = asked_of(lua);
  const std::size_t most = count_argument(lua, 2, 1, 1, kPastRecent);
  const auto watched = watch_vectors(lua, asked);
  if (!watched || watched->since.size() < most) return nothing(lua);
  const std::span<const Vector2d> latest(watched->since.end() - static_cast<std::ptrdiff_t>(most),
                                         watched->since.end());
  const auto test = hotelling_two_sample(latest, watched->baseline);
  if (!test) return nothing(lua);
  const auto n1 = static_cast<double>(latest.size());
  const auto n2 = static_cast<double>(watched->baseline.size());
  const double moved = (sample_of(latest).mean - watched->sample.mean).norm();
  return answer(lua, {std::sqrt(test->t2 * (n1 + n2) / (n1 * n2)), test->p_value, moved});
}

int vector_cusum_since_baseline(lua_State* lua) {
  Asked& asked = asked_of(lua);
  const double allowance = positive_argument(lua, 2, 1.5, 100.0);
  const auto watched = watch_vectors(lua, asked);
  if (!watched) return nothing(lua);
  return answer(lua,
                {vector_cusum(watched->since, watched->sample.mean, *watched->sample.covariance, allowance)});
}

constexpr std::array<luaL_Reg, 13> kFunctions{{{"count", count},
                                               {"last", last},
                                               {"mean", mean_of_latest},
                                               {"median", median_of_latest},
                                               {"spread", spread_of_latest},
                                               {"slope", slope},
                                               {"days_until", days_until},
                                               {"percent", percent},
                                               {"baseline", baseline},
                                               {"ewma", ewma_since_baseline},
                                               {"cusum", cusum_since_baseline},
                                               {"distance", distance},
                                               {"vector_cusum", vector_cusum_since_baseline}}};

}  // namespace

std::span<const luaL_Reg> questions() { return kFunctions; }

}  // namespace ballbar

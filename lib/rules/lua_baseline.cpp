#include <algorithm>
#include <array>
#include <cmath>
#include <lua.hpp>

#include "numerics/hotelling.hpp"
#include "numerics/statistics.hpp"
#include "numerics/trend.hpp"
#include "rules/lua_asking.hpp"
#include "rules/lua_questions.hpp"
#include "rules/names.hpp"
#include "rules/sandbox_library.hpp"

namespace ballbar {
namespace {

using Eigen::Vector2d;
using Values = std::vector<double>;

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

constexpr std::array<luaL_Reg, 5> kBaselineFunctions{{{"baseline", baseline},
                                                      {"ewma", ewma_since_baseline},
                                                      {"cusum", cusum_since_baseline},
                                                      {"distance", distance},
                                                      {"vector_cusum", vector_cusum_since_baseline}}};

}  // namespace

std::span<const luaL_Reg> baseline_questions() { return kBaselineFunctions; }

}  // namespace ballbar

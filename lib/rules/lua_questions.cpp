#include "rules/lua_questions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <lua.hpp>

#include "numerics/statistics.hpp"
#include "numerics/trend.hpp"
#include "rules/lua_asking.hpp"
#include "rules/sandbox_library.hpp"

namespace ballbar {
namespace {

using Values = std::vector<double>;

constexpr double kUsPerDay = 86'400e6;
constexpr int kMostSlopes = 100;  // results of a slope: their pairs are what takes time
constexpr long long kSlopesCost = 5 * kQuestionCost;

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
  charge(lua, kSlopesCost);
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

constexpr std::array<luaL_Reg, 8> kLatestFunctions{{{"count", count},
                                                    {"last", last},
                                                    {"mean", mean_of_latest},
                                                    {"median", median_of_latest},
                                                    {"spread", spread_of_latest},
                                                    {"slope", slope},
                                                    {"days_until", days_until},
                                                    {"percent", percent}}};

}  // namespace

std::span<const luaL_Reg> latest_questions() { return kLatestFunctions; }

}  // namespace ballbar

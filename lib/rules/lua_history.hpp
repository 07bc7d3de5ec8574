#pragma once
/// `history` as Lua sees it. All calls in protected mode.
///
///     history.series_first, .recent          arrays of earlier results, oldest first: the first 20 of the
///     same series,
///                                            the latest 50 of all
///     history.count(name)                    how many of the latest 200 hold the quantity
///     history.last(name, k)                  its value k results ago (1)
///     history.mean, median, spread(name, n)  of the latest n (20) before this one; spread = 1.4826 median
///                                            |x - median|; from 2, 3, 5 values on
///     history.slope(name, n)                 per day over the latest n (30) and this one, low, high:
///     Theil-Sen, 95 %
///                                            (Sen 1968); from 5 values on
///     history.days_until(name, limit, n)     days until the level reaches the limit at the present slope;
///     math.huge
///                                            where the slope's interval holds no such direction
///     history.percent(name, limit)           100 |value| / limit
///     history.baseline(name)                 mean, standard deviation and count of the baseline
///     history.ewma(name, weight)             EWMA since the baseline (weight 0.2), and its distance in its
///     own sd history.cusum(name, allowance)         CUSUM up and down since the baseline, in its sd
///     (allowance 1.5) history.distance(vector, n)            of the mean of the latest n (1) with this one
///     from the baseline's, in sd
///                                            of a single result; chance of that where nothing moved
///                                            (Hotelling); um
///     history.vector_cusum(vector, allowance)  Crosier's CUSUM since the baseline, in sd (allowance 1.5)
///
/// `vector` is "ovality", "harmonic<k>" or "gap_harmonic<k>". Each gives nil while there are fewer values
/// than it needs, or where the baseline is not complete or does not scatter; a quantity that this result does
/// not have is an error, a name that none can have too.

#include <exception>

#include "core/past.hpp"
#include "rules/rule.hpp"

struct lua_State;

namespace ballbar {

/// What one call of `when` is about; outlives the run of the script.
struct Asked {
  const Rule& rule;
  const Record& record;
  Past& past;
  std::exception_ptr failed;  ///< of `past`: to be thrown again after the script has ended
};

void push_history(lua_State* lua, Asked& asked);

}  // namespace ballbar

#pragma once
/// Pages for people: `ballbar report` and `ballbar compare -o`.

#include <optional>
#include <string>
#include <vector>

#include "daemon/json_out.hpp"
#include "daemon/pictures.hpp"
#include "store/store.hpp"

namespace ballbar {

/// Conditions, figures with what they mean, pictures, measured against predicted, what changed against the
/// baseline, alarms.
/// @param runs      at least one, oldest first, of any status
/// @param baseline  a series; empty: the first one of each robot and test
/// @param rules     whose limits are drawn in trends
/// @throws Error(kInput) where the baseline has no run of these robots and tests
std::string report_page(const Store& store, const std::vector<StoredRun>& runs, const std::string& baseline,
                        const std::vector<Rule>& rules);

/// @param comparison  compare_json() of the two
std::string compare_page(const Store& store, const std::vector<StoredRun>& before,
                         const std::vector<StoredRun>& after, const Json& comparison);

/// Pictures as part of a page, each robot and test by itself.
/// @param runs   ok ones, at least one
/// @param trend  options of a trend of this and earlier runs; nothing: none
std::string pictures_html(const Store& store, const std::vector<StoredRun>& runs,
                          const std::optional<PictureOptions>& trend);

/// What stood at `path` is replaced only when the page is complete.
/// @throws Error(kInput) where the name does not end in .html, Error(kWorld) where it cannot be written
void write_page(const std::string& path, const std::string& page);

}  // namespace ballbar

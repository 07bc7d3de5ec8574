#pragma once
/// What the pictures of pictures.hpp share.

#include <string>
#include <vector>

#include "daemon/pictures.hpp"

namespace ballbar {

struct Heading {
  std::string title, subtitle;
};

/// Robots and tests; series and the first run's begin. @param runs  at least one
Heading heading_of(const std::vector<StoredRun>& runs);

/// "before A   clockwise"
std::string with_way(const std::string& group, TestKind kind, int direction);

/// PictureKind::kTrend
PlotScript trend_picture(const Store& store, const std::vector<StoredRun>& chosen,
                         const PictureOptions& options);

}  // namespace ballbar

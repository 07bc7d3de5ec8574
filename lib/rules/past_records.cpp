#include "rules/past_records.hpp"

#include <algorithm>
#include <cmath>

namespace ballbar {
namespace {

constexpr std::string_view kNamed = "series ";

void keep(std::vector<Record>& found, std::size_t most, bool newest) {
  if (found.size() <= most) return;
  const auto extra = static_cast<std::ptrdiff_t>(found.size() - most);
  if (newest) {
    found.erase(found.begin(), found.begin() + extra);
  } else {
    found.erase(found.end() - extra, found.end());
  }
}

}  // namespace

PastRecords::PastRecords(const Record& record, const History& history) : record_(record) {
  const auto ok = [](const std::vector<Record>& records) {
    std::vector<Record> found;
    std::copy_if(records.begin(), records.end(), std::back_inserter(found),
                 [](const Record& r) { return r.status == "ok"; });
    return found;
  };
  all_ = ok(history.recent);
  windows_["series"] = ok(history.series_first);
}

PastRecords::PastRecords(const Record& record, const std::vector<Record>& all,
                         const std::vector<std::int64_t>& marks_us)
    : record_(record), marks_us_(marks_us) {
  std::copy_if(all.begin(), all.end(), std::back_inserter(all_), [&](const Record& other) {
    return other.status == "ok" && other.robot == record.robot && other.test == record.test &&
           other.kind == record.kind && other.direction == record.direction && other.axis == record.axis &&
           other.source == record.source && other.started_us < record.started_us;
  });
}

const std::vector<Record>& PastRecords::window(const std::string& which) {
  if (const auto found = windows_.find(which); found != windows_.end()) return found->second;
  std::vector<Record> found;
  std::int64_t since_us = INT64_MIN;
  for (const std::int64_t mark : marks_us_)
    if (which == "calibration" && mark <= record_.started_us) since_us = std::max(since_us, mark);
  for (const Record& record : all_) {
    if (which == "series" && record.series != record_.series) continue;
    if (which.starts_with(kNamed) && record.series != which.substr(kNamed.size())) continue;
    if (record.started_us >= since_us) found.push_back(record);
  }
  keep(found, which == "recent" ? kPastRecent : kPastFirst, which == "recent");
  return windows_[which] = std::move(found);
}

const std::vector<double>& PastRecords::column(const std::string& which, const std::string& name) {
  std::vector<double>& values = columns_[which][name];
  const std::vector<Record>& records = window(which);
  if (values.size() == records.size()) return values;
  for (const Record& record : records) {
    const auto found = record.values.find(name);
    values.push_back(found != record.values.end() ? found->second.value : std::nan(""));
  }
  return values;
}

}  // namespace ballbar

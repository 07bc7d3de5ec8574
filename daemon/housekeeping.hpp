#pragma once
/// What the service does beside the runs: retention, the WAL's size, metrics.

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "bus/channels.hpp"
#include "bus/publisher.hpp"
#include "daemon/config.hpp"
#include "store/maintenance.hpp"
#include "store/store.hpp"

namespace ballbar {

using RefusedByReason = std::array<std::int64_t, kRefusals>;

/// The status and the database's size as Prometheus text, one HELP and TYPE line each.
std::string metrics_text(const DaemonStatus& status, const RefusedByReason& refused, std::int64_t data_bytes,
                         std::int64_t wal_bytes);

class Housekeeping {
 public:
  /// To be called once a second; each call takes some milliseconds. @return lines for the journal
  std::vector<std::string> on_second(Store& store, const Config& config, const DaemonStatus& status,
                                     const RefusedByReason& refused);

 private:
  std::optional<std::string> empty_wal(Store& store);
  std::optional<std::string> retain(Store& store, const Config& config, std::int64_t now_us);
  std::optional<std::string> write_metrics(Store& store, const Config& config, const DaemonStatus& status,
                                           const RefusedByReason& refused);

  Retention retention_;
  Removed removed_;  ///< since it was last said
  std::uint64_t seconds_ = 0;
  std::array<std::string, 3> trouble_;  ///< of each, said already
  bool wal_is_held_ = false;            ///< likewise
};

}  // namespace ballbar

#include "daemon/housekeeping.hpp"

#include <filesystem>
#include <utility>

#include "core/error.hpp"

namespace ballbar {
namespace {

constexpr std::uint64_t kMetricsSeconds = 15;
constexpr std::uint64_t kCheckpointSeconds = 60;
constexpr std::int64_t kLargeWalBytes = std::int64_t{4}
                                        << 20;  // as large as SQLite lets it be between checkpoints
constexpr std::int64_t kHeldWalBytes = std::int64_t{64} << 20;  // a reader holds it
constexpr std::int64_t kDayUs = 86'400'000'000;
constexpr std::int64_t kMegabyte = 1'000'000;

std::int64_t size_of(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 0 : static_cast<std::int64_t>(size);
}

struct Metric {
  const char* name;
  const char* type;
  const char* help;
  std::int64_t value;
};

}  // namespace

std::string metrics_text(const DaemonStatus& s, const RefusedByReason& refused, std::int64_t data_bytes,
                         std::int64_t wal_bytes) {
  const Metric metrics[] = {
      {"ballbard_listening", "gauge", "1 where messages can arrive", s.state == "listening" ? 1 : 0},
      {"ballbard_messages_total", "counter", "messages received", s.messages},
      {"ballbard_messages_lost_total", "counter", "messages that senders numbered and did not arrive",
       s.lost_messages},
      {"ballbard_datagrams_dropped_total", "counter",
       "datagrams that the kernel dropped, its buffer being full", s.kernel_drops},
      {"ballbard_receiver_restarts_total", "counter", "deaths of the receiver", s.receiver_restarts},
      {"ballbard_runs_stored_total", "counter", "runs stored since the start", s.runs_stored},
      {"ballbard_runs_ok_total", "counter", "runs stored whose status is ok", s.runs_ok},
      {"ballbard_runs_open", "gauge", "runs in progress", s.runs_open},
      {"ballbard_runs_waiting", "gauge", "runs in memory that could not be stored yet", s.runs_waiting},
      {"ballbard_store_failures_total", "counter", "writes that failed", s.store_failures},
      {"ballbard_database_bytes", "gauge", "data in the database", data_bytes},
      {"ballbard_wal_bytes", "gauge", "size of the write-ahead log", wal_bytes},
      {"ballbard_rules", "gauge", "alarm rules in use", s.rules},
      {"ballbard_rule_errors", "gauge", "alarm rules that fail", s.rule_errors},
      {"ballbard_alarms_firing", "gauge", "alarms that fire", s.alarms_firing},
      {"ballbard_time_seconds", "gauge", "when this was written", s.time_us / 1'000'000},
  };
  std::string text =
      "# HELP ballbard_info version of ballbard\n# TYPE ballbard_info gauge\nballbard_info{version=\"" +
      s.version + "\"} 1\n";
  for (const Metric& m : metrics) {
    const std::string name = m.name;
    text.append("# HELP ").append(name).append(" ").append(m.help);
    text.append("\n# TYPE ").append(name).append(" ").append(m.type);
    text.append("\n").append(name).append(" ").append(std::to_string(m.value)).append("\n");
  }
  text +=
      "# HELP ballbard_messages_refused_total messages refused, by reason\n"
      "# TYPE ballbard_messages_refused_total counter\n";
  for (std::size_t i = 0; i < kRefusals; ++i)
    text.append("ballbard_messages_refused_total{reason=\"")
        .append(kRefusalNames[i])
        .append("\"} ")
        .append(std::to_string(refused[i]))
        .append("\n");
  return text;
}

std::vector<std::string> Housekeeping::on_second(Store& store, const Config& config,
                                                 const DaemonStatus& status, const RefusedByReason& refused) {
  ++seconds_;
  std::vector<std::string> lines;
  // Each by itself: where the database cannot be written, the figures say so all the same.
  const auto each = [&lines](std::string& trouble, const auto& work) {
    try {
      if (const std::optional<std::string> said = work()) lines.push_back(*said);
      trouble.clear();
    } catch (const Error& error) {
      if (trouble != error.what()) lines.emplace_back(error.what());
      trouble = error.what();
    }
  };
  each(trouble_[0], [&] { return retain(store, config, status.time_us); });
  if (seconds_ % kMetricsSeconds == 1)
    each(trouble_[1], [&] { return write_metrics(store, config, status, refused); });
  if (seconds_ % kCheckpointSeconds == 0) each(trouble_[2], [&] { return empty_wal(store); });
  return lines;
}

std::optional<std::string> Housekeeping::retain(Store& store, const Config& config, std::int64_t now_us) {
  const RetentionLimits limits{config.keep_days * kDayUs, config.keep_traces_days * kDayUs,
                               config.max_size_mb * kMegabyte};
  if (limits.keep_us == 0 && limits.keep_traces_us == 0 && limits.max_bytes == 0) return {};
  const Removed now = retention_.step(store, limits, now_us);
  removed_ += now;
  if (!now.none() || removed_.none()) return {};
  const Removed all = std::exchange(removed_, Removed{});
  return "retention: deleted " + std::to_string(all.traces) + " recordings, " + std::to_string(all.runs) +
         " runs, " + std::to_string(all.diagnoses) + " diagnoses, " + std::to_string(all.events) +
         " alarm events";
}

std::optional<std::string> Housekeeping::empty_wal(Store& store) {
  const std::int64_t wal = size_of(store.path() + "-wal");
  if (wal < kLargeWalBytes || store.checkpoint())
    wal_is_held_ = false;
  else if (wal >= kHeldWalBytes && !std::exchange(wal_is_held_, true))
    return store.path() + "-wal grows, " + std::to_string(wal / kMegabyte) +
           " MB: a program holds the database open for reading; close it";
  return {};
}

std::optional<std::string> Housekeeping::write_metrics(Store& store, const Config& config,
                                                       const DaemonStatus& status,
                                                       const RefusedByReason& refused) {
  if (!config.metrics_path.empty())
    write_text(config.metrics_path,
               metrics_text(status, refused, data_bytes(store), size_of(store.path() + "-wal")));
  return {};
}

}  // namespace ballbar

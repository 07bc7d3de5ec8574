#pragma once
/// Tells people: runs the [notify] command with one event after another on its standard input.

#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "daemon/config.hpp"
#include "daemon/log.hpp"
#include "store/store.hpp"

namespace ballbar {

/// What is told is what the database holds: events behind the one that was told last, so that nothing is
/// forgotten over a restart, and memory holds one at a time. Each is told at least once. Nothing here waits:
/// the command runs beside the event loop.
class Notifier {
 public:
  /// Whether the command fails, and how: for the alarm about it.
  using Failing = std::function<void(bool, const std::string&)>;
  using Log = std::function<void(Priority, const std::string&)>;

  Notifier(Store& store, Log log, Failing failing);
  ~Notifier();
  Notifier(const Notifier&) = delete;
  Notifier& operator=(const Notifier&) = delete;

  /// @param event  the loop; null until it runs
  /// Where there was no command until now, what happened before is not told.
  void configure(const NotifySpec& spec, sd_event* event);

  /// Starts the command where something is to be told, ends one that takes too long.
  /// @param now_us  steady clock
  void tick(std::uint64_t now_us);

  /// The store is another one now, whose events begin at 1: all of them are to be told.
  void on_new_store();

 private:
  void find_begin();
  std::optional<StoredEvent> next();
  void start(const StoredEvent& event, std::uint64_t now_us);
  void ended();
  void failed(const std::string& how, std::uint64_t now_us);
  void told();
  void end_process();
  void forget_process();

  Store& store_;
  Log log_;
  Failing failing_;
  NotifySpec spec_;
  sd_event* event_ = nullptr;
  sd_event_source* source_ = nullptr;
  int pid_ = -1;
  int pidfd_ = -1;
  bool overdue_ = false;
  std::string trouble_;               ///< of the database, said already
  std::optional<std::int64_t> last_;  ///< event that was told last; nothing until the database has said so
  std::int64_t current_ = 0;          ///< event that is being told
  int failures_ = 0;                  ///< in a row
  std::uint64_t now_us_ = 0, started_us_ = 0, next_try_us_ = 0, first_try_us_ = 0;
};

/// True for what people are told: an alarm fires or is over, and is neither shelved nor about the command
/// itself, nor below the severity; and one that fires still when its shelving ends.
bool worth_telling(const AlarmEvent& event, const std::string& least_severity);

}  // namespace ballbar

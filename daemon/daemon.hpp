#pragma once
/// The event loop of ballbard: receiver, signals, timers, watchdog. The only one that reads a clock.
/// daemon_watch.cpp: what it says of itself.

#include <systemd/sd-event.h>

#include <array>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "bus/assembler.hpp"
#include "bus/receiver.hpp"
#include "daemon/control.hpp"
#include "daemon/housekeeping.hpp"
#include "daemon/live_diagnosis.hpp"
#include "daemon/notifier.hpp"
#include "daemon/rule_keeper.hpp"
#include "daemon/service.hpp"

namespace ballbar {

/// [ms] A running service waits no longer for another program that writes: what is not stored now waits in
/// memory, and the watchdog wants to hear of each turn of the loop.
inline constexpr int kWaitForOthersMs = 500;
/// [us] After this time in one turn no further run is analysed.
inline constexpr std::uint64_t kTurnUs = 1'000'000;

class Daemon {
 public:
  /// Opens everything but the bus.
  /// @param program  path of this program, for the receiver
  /// @throws Error where the configuration, a URDF or the database cannot be used
  Daemon(Config config, const std::string& program);
  ~Daemon();

  /// Runs until SIGTERM or SIGINT. @return exit code
  int run();

 private:
  void start_receiver();
  int on_receiver(int most_frames);
  bool is_behind() const;
  void on_frame(const ReceiverFrame& frame, std::span<const std::uint8_t> bytes);
  void receiver_gone();
  void on_tick();
  void on_second();
  void on_signal(int signal);
  void reload();
  void reload_rules();
  void stop();
  void take_finished();
  void count_hole(const std::string& why);
  void publish_status();
  void say_seldom(const std::string& kind, const std::string& text);
  void count_refusal(Refusal reason, const std::string& detail);
  void sum_up_refusals();
  void look_for_damaged();
  void replace_damaged_store();
  void open_publisher();
  void open_control();
  void notify_status() const;
  DaemonStatus status() const;

  std::unique_ptr<Store> store_;
  std::unique_ptr<Service> service_;
  std::unique_ptr<RuleKeeper> rule_keeper_;
  std::unique_ptr<Notifier> notifier_;
  std::unique_ptr<ControlSocket> control_;
  std::unique_ptr<Assembler> assembler_;
  std::unique_ptr<ReceiverProcess> receiver_;
  std::unique_ptr<LiveDiagnosis> diagnosis_;
  sd_event* event_ = nullptr;
  sd_event_source* receiver_source_ = nullptr;
  sd_event_source* tick_source_ = nullptr;

  std::vector<Run> finished_;
  bool listening_ = false;
  bool ready_ = false;
  std::uint64_t started_us_ = 0;           ///< steady clock
  std::uint64_t receiver_started_us_ = 0;  ///< steady clock
  int unheard_ = 0;                        ///< own status messages since the receiver's last frame
  std::uint64_t restart_at_us_ = 0;        ///< steady clock; 0: the receiver runs
  std::uint64_t ticks_ = 0;
  std::int64_t wall_ahead_us_ = 0;  ///< of the steady clock
  std::int64_t receiver_restarts_ = 0;
  std::int64_t kernel_drops_ = 0;
  std::int64_t kernel_drops_before_ = 0;  ///< of receivers that are gone
  std::string bus_error_;
  std::string last_error_;
  std::set<std::string> said_;                            ///< one line per kind and minute
  std::array<std::int64_t, kRefusals> refused_before_{};  ///< a minute ago
  std::string damaged_;                                   ///< what is said while a database lies set aside
  bool store_is_away_ = false;                            ///< set aside, and no new one begun yet
  Housekeeping housekeeping_;
};

}  // namespace ballbar

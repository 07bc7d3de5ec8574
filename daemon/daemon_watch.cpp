/// What the service says of itself: status, what it refused, a damaged database.

#include <systemd/sd-daemon.h>

#include "core/error.hpp"
#include "daemon/clock.hpp"
#include "daemon/daemon.hpp"
#include "store/set_aside.hpp"
#include "version.hpp"

namespace ballbar {
namespace {

/// The service's own status, sent once a second, comes back. Where an interface was deleted and made again,
/// liblcm stays deaf for ever.
constexpr int kDeafAfter = 5;

}  // namespace

/// Counted in what was sent, not in time: who stood still himself heard nothing either.
void Daemon::publish_status() {
  Publisher* publisher = service_->publisher();
  if (!publisher) return;
  publisher->publish(status());
  if (is_behind()) unheard_ = 0;  // nobody listens at the moment
  if (!listening_ || !service_->config().bus_url.starts_with("udpm:") || ++unheard_ <= kDeafAfter) return;
  count_hole("not even the service's own status is heard: the receiver is opened again");
  start_receiver();
}

/// One line per kind, and again after a minute: a flood must not fill the journal.
void Daemon::say_seldom(const std::string& kind, const std::string& text) {
  if (!said_.insert(kind).second) return;
  log_line(Priority::kWarning, text + " (further ones of this kind are only counted for a minute)");
}

void Daemon::count_refusal(Refusal reason, const std::string& detail) {
  const std::string word(kRefusalNames[static_cast<std::size_t>(reason)]);
  say_seldom(word, "refused " + detail + ": " + word);
}

/// At the end of a minute: what was only counted.
void Daemon::sum_up_refusals() {
  said_.clear();
  const auto& refused = assembler_->counters().refused;
  std::string line;
  for (std::size_t i = 0; i < kRefusals; ++i)
    if (const std::int64_t n = refused[i] - refused_before_[i]; n > 1)
      line += (line.empty() ? "" : ", ") + std::to_string(n) + " " + std::string(kRefusalNames[i]);
  refused_before_ = refused;
  if (!line.empty()) log_line(Priority::kWarning, "refused in the last minute: " + line);
}

/// The alarm stays until somebody has recovered or removed what was set aside.
void Daemon::look_for_damaged() {
  const std::vector<std::string> found = set_aside_before(store_->path());
  std::string text;
  if (!found.empty())
    text = "a damaged database was set aside as " + found.back() +
           "; a new one goes on from here: 'ballbar db recover " + found.back() +
           "' gets back what it still holds and moves it away";
  service_->alarms().own(kDamagedAlarm, !text.empty(), text, wall_us(), "critical");
  if (text == damaged_) return;
  damaged_ = text;
  if (!text.empty()) return log_line(Priority::kError, text);
  log_line(Priority::kNotice, "no damaged database lies set aside any more");
}

/// SQLite met damage while it ran. The runs that wait go into a new database.
void Daemon::replace_damaged_store() {
  try {
    store_->database().set_checkpoint_on_close(false);
    const std::string path = store_->path();
    if (!store_is_away_) set_aside(path);
    store_is_away_ = true;
    *store_ = Store(path);
    store_->database().set_busy_timeout(kWaitForOthersMs);
    store_is_away_ = false;
    housekeeping_ = Housekeeping{};
    notifier_->on_new_store();
    service_->on_new_store();
    reload_rules();
    look_for_damaged();
    service_->retry(kTurnUs);
  } catch (const StoreError& error) {
    if (last_error_ == error.what()) return;
    last_error_ = error.what();
    log_line(Priority::kError, last_error_);
  }
}

void Daemon::notify_status() const {
  const DaemonStatus s = status();
  sd_notifyf(0,
             "STATUS=%s; %lld runs stored, %lld messages, %lld lost, %lld refused, %d rules of generation "
             "%d, %d alarms "
             "firing%s%s",
             s.state.c_str(), static_cast<long long>(s.runs_stored), static_cast<long long>(s.messages),
             static_cast<long long>(s.lost_messages), static_cast<long long>(s.refused), s.rules,
             s.rules_generation, s.alarms_firing,
             s.last_error.empty() ? "" : "; last error: ", s.last_error.c_str());
}

DaemonStatus Daemon::status() const {
  DaemonStatus s;
  s.time_us = wall_us();
  s.version = kVersion;
  s.state = listening_ ? "listening" : "waiting for the network";
  s.database = store_->path();
  s.last_error = !bus_error_.empty() ? bus_error_ : !damaged_.empty() ? damaged_ : last_error_;
  s.messages = assembler_->counters().messages;
  s.refused = assembler_->counters().refused_total();
  s.lost_messages = assembler_->counters().lost_messages;
  s.kernel_drops = kernel_drops_;
  s.receiver_restarts = receiver_restarts_;
  s.runs_stored = service_->counters().runs_stored;
  s.runs_ok = service_->counters().runs_ok;
  s.runs_open = assembler_->open_runs();
  s.store_failures = service_->counters().store_failures;
  s.runs_waiting = static_cast<std::int64_t>(service_->waiting());
  s.rules = static_cast<int>(service_->rules().rules().size());
  s.rules_generation = rule_keeper_->generation();
  s.rule_errors = static_cast<int>(service_->rule_errors().size() + rule_keeper_->errors().size());
  s.alarms_firing = service_->alarms_firing();
  return s;
}

}  // namespace ballbar

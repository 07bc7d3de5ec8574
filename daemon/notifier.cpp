#include "daemon/notifier.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "bus/spawn.hpp"
#include "daemon/alarm_book.hpp"
#include "daemon/alarm_json.hpp"

namespace ballbar {
namespace {

constexpr int kFailuresUntilAlarm = 3;
constexpr double kLongestPauseS = 600.0;
constexpr std::uint64_t kGiveUpUs = std::uint64_t{24} * 3600 * 1'000'000;
constexpr int kNotToBeTriedAgain = 65;  // EX_DATAERR of sysexits.h: the command will never take this one
constexpr std::int64_t kAtATime = 50;   // events read

int rank(const std::string& severity) { return severity == "critical" ? 2 : severity == "warning" ? 1 : 0; }

/// A file in memory: writing to it never waits, whoever reads or does not.
int file_of(const std::string& text) {
  const int fd = memfd_create("ballbard-notify", MFD_CLOEXEC);
  if (fd < 0) return -1;
  if (write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && lseek(fd, 0, SEEK_SET) == 0)
    return fd;
  close(fd);
  return -1;
}

}  // namespace

bool worth_telling(const AlarmEvent& event, const std::string& least_severity) {
  const AlarmStatus& alarm = event.status;
  if (alarm.key.rule == kNotifyAlarm || rank(alarm.severity) < rank(least_severity)) return false;
  if (event.change == AlarmChange::kUnshelved) return alarm.state == AlarmState::kFiring;
  if (event.change != AlarmChange::kState || alarm.shelved.until_us != 0) return false;
  return alarm.state == AlarmState::kFiring || event.from == AlarmState::kFiring;
}

Notifier::Notifier(Store& store, Log log, Failing failing)
    : store_(store), log_(std::move(log)), failing_(std::move(failing)) {}

Notifier::~Notifier() { end_process(); }  // it is told again after the next start

void Notifier::end_process() {
  if (pid_ > 0) {
    kill(-pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  forget_process();
}

void Notifier::configure(const NotifySpec& spec, sd_event* event) {
  event_ = event;
  if (spec.command != spec_.command) {
    failures_ = 0;
    next_try_us_ = 0;
  }
  spec_ = spec;
  try {
    if (spec_.command.empty()) {
      end_process();  // what it tells is nobody's wish any more
      last_.reset();
      failing_(false, "");
      store_.forget_notified();
    } else {
      find_begin();
    }
  } catch (const StoreError& error) {
    log_(Priority::kError, std::string("[notify]: ") + error.what());
  }
}

void Notifier::find_begin() {
  if (last_) return;
  last_ = store_.notified();
  if (last_) return;
  last_ = store_.last_event();
  store_.save_notified(*last_);
}

void Notifier::tick(std::uint64_t now_us) {
  now_us_ = now_us;
  if (pid_ > 0) {
    if (static_cast<double>(now_us - started_us_) * 1e-6 < spec_.time_limit_s || overdue_) return;
    overdue_ = true;
    kill(-pid_, SIGKILL);
    return;
  }
  if (spec_.command.empty() || event_ == nullptr || now_us < next_try_us_) return;
  try {
    find_begin();
    const std::optional<StoredEvent> event = next();
    trouble_.clear();
    if (event) start(*event, now_us);
  } catch (const StoreError& error) {
    next_try_us_ = now_us + 5'000'000;
    if (trouble_ != error.what()) log_(Priority::kError, std::string("[notify]: ") + error.what());
    trouble_ = error.what();
  }
}

void Notifier::on_new_store() {
  if (!last_) return;
  last_ = current_ = 0;
  next_try_us_ = 0;
  try {
    store_.save_notified(0);
  } catch (const StoreError& error) {
    log_(Priority::kError, std::string("[notify]: ") + error.what());
  }
}

std::optional<StoredEvent> Notifier::next() {
  EventFilter filter;
  filter.after_id = last_;
  filter.limit = kAtATime;
  filter.states_only = false;
  for (StoredEvent& event : store_.events(filter)) {
    if (worth_telling(event.event, spec_.severity)) return std::move(event);
    last_ = event.id;  // not stored: it would only be passed over again
  }
  return std::nullopt;
}

void Notifier::start(const StoredEvent& event, std::uint64_t now_us) {
  if (current_ != event.id) first_try_us_ = now_us;
  current_ = event.id;
  started_us_ = now_us;
  overdue_ = false;
  const int input = file_of(text_of(notification(event)));
  if (input < 0) return failed(std::string("no memory for its input: ") + std::strerror(errno), now_us);
  pid_t pid = -1;
  // What it prints goes to our standard error, that is, to the journal.
  const int error = spawn({.command = spec_.command,
                           .files = {{input, STDIN_FILENO}, {STDERR_FILENO, STDOUT_FILENO}},
                           .apart = true},
                          pid);
  close(input);
  if (error != 0) return failed(spec_.command[0] + ": " + std::strerror(error), now_us);
  pid_ = pid;
  pidfd_ = static_cast<int>(syscall(SYS_pidfd_open, pid, 0));  // glibc 2.36 declares it as C++
  const auto on_end = [](sd_event_source*, int, std::uint32_t, void* self) {
    auto* notifier = static_cast<Notifier*>(self);
    try {
      notifier->ended();
    } catch (const std::exception& unforeseen) {  // nothing may pass through sd-event, which is C
      notifier->log_(Priority::kError, std::string("[notify]: not foreseen: ") + unforeseen.what());
    }
    return 0;
  };
  if (pidfd_ >= 0 && sd_event_add_io(event_, &source_, pidfd_, EPOLLIN, on_end, this) >= 0) return;
  kill(-pid, SIGKILL);
  waitpid(pid, nullptr, 0);
  forget_process();
  failed("it cannot be watched", now_us);
}

void Notifier::forget_process() {
  source_ = sd_event_source_disable_unref(source_);
  if (pidfd_ >= 0) close(pidfd_);
  pidfd_ = -1;
  pid_ = -1;
}

void Notifier::ended() {
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) == 0) return;
  kill(-pid_, SIGKILL);  // what it has started and left behind
  const bool overdue = overdue_;
  forget_process();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return told();
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotToBeTriedAgain) {
    log_(Priority::kError, "[notify] " + spec_.command[0] + " refuses event " + std::to_string(current_) +
                               " for good (exit code 65); it is not told");
    return told();
  }
  failed(
      spec_.command[0] + (overdue             ? " took longer than its time limit"
                          : WIFEXITED(status) ? " ended with exit code " + std::to_string(WEXITSTATUS(status))
                                              : " was ended by signal " + std::to_string(WTERMSIG(status))),
      now_us_);
}

void Notifier::failed(const std::string& how, std::uint64_t now_us) {
  ++failures_;
  const double pause_s = std::min(kLongestPauseS, spec_.retry_s * std::pow(2.0, std::min(failures_, 30) - 1));
  next_try_us_ = now_us + static_cast<std::uint64_t>(pause_s * 1e6);
  log_(Priority::kWarning, "[notify] " + how + "; event " + std::to_string(current_) + " waits, " +
                               std::to_string(failures_) + " failures in a row");
  if (failures_ >= kFailuresUntilAlarm) failing_(true, "nobody is told of alarms: " + how);
  if (now_us - first_try_us_ < kGiveUpUs) return;
  log_(Priority::kError,
       "[notify] event " + std::to_string(current_) + " could not be told for 24 h and is given up");
  last_ = current_;
}

void Notifier::told() {
  last_ = current_;
  failures_ = 0;
  next_try_us_ = 0;
  failing_(false, "");
  try {
    store_.save_notified(current_);
  } catch (const StoreError& error) {
    log_(Priority::kError, std::string("[notify]: told, but not noted: ") + error.what());
  }
}

}  // namespace ballbar

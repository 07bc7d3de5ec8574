#include "daemon/daemon.hpp"

#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "bus/decode.hpp"
#include "core/error.hpp"
#include "daemon/clock.hpp"
#include "store/set_aside.hpp"
#include "version.hpp"

namespace ballbar {
namespace {

constexpr std::uint64_t kTickUs = 250'000;
constexpr std::uint64_t kTicksPerSecond = 4;
constexpr std::uint64_t kReadyAnywayUs =
    15'000'000;  // no multicast route at start: wait and say so, do not die
constexpr std::uint64_t kReceiverRetryUs = 1'000'000;  // where the bus cannot be opened
constexpr std::uint64_t kReceiverShortUs = 1'000'000;  // a receiver that died so young is not started at once
constexpr std::uint64_t kReceiverPauseUs = 200'000;
constexpr std::uint64_t kRetryStoreSeconds = 2;
constexpr std::uint64_t kStatusSeconds = 5;
constexpr std::uint64_t kRepeatAlarmsSeconds = 30;
constexpr std::uint64_t kForgetRefusalsSeconds = 60;
constexpr std::uint64_t kJudgeTimeSeconds = 60;
constexpr std::uint64_t kBeforeReloadUs = 10'000'000;
constexpr std::int64_t kClockWasSetUs = 3'600'000'000;
constexpr std::size_t kMostBehind = 50;  // runs that wait for their analysis: then nothing more is read
constexpr int kFramesPerTurn = 256;
constexpr int kFramesPerTick = 20'000;
constexpr std::uint64_t kDrainUs = 2'000'000;         // at stop: for what the receiver still holds
constexpr std::uint64_t kLastRetriesUs = 20'000'000;  // at stop: for a database that cannot be written

/// sd-event is C: no exception may pass through it. What was not foreseen ends the loop; systemd starts us
/// again.
template <typename Work>
int guarded(sd_event* event, Work work) {
  try {
    work();
    return 0;
  } catch (const std::exception& error) {
    log_line(Priority::kError, std::string("not foreseen: ") + error.what());
    return sd_event_exit(event, -EIO);
  }
}

void check(int result, const char* what) {
  if (result < 0)
    throw Error(Cause::kWorld, std::string("event loop: ") + what + ": " + std::strerror(-result));
}

}  // namespace

Daemon::Daemon(Config config, const std::string& program) {
  Models models = load_models(config);
  OpenedStore opened = open_or_set_aside(config.store_path);
  if (!opened.set_aside.empty()) log_line(Priority::kError, opened.damage);
  store_ = std::make_unique<Store>(std::move(opened.store));
  if (!opened.set_aside.empty()) store_->save_notified(0);  // that it was is the first thing to be told
  store_->database().set_busy_timeout(kWaitForOthersMs);
  assembler_ = std::make_unique<Assembler>(config.robots, AssemblerLimits{}, recogniser_of(models));
  receiver_ =
      std::make_unique<ReceiverProcess>(std::vector<std::string>{program, "--receive"}, config.bus_url);
  service_ = std::make_unique<Service>(std::move(config), std::move(models), RuleSet{}, *store_, log_line);
  rule_keeper_ = std::make_unique<RuleKeeper>(*store_, log_line);
  notifier_ = std::make_unique<Notifier>(*store_, log_line, [this](bool fails, const std::string& how) {
    service_->alarms().own(kNotifyAlarm, fails, how, wall_us());
  });
  diagnosis_ = std::make_unique<LiveDiagnosis>(program, *service_, *store_, log_line);
  service_->on_stored([this](const Run& run, const RunResult& result) {
    diagnosis_->heard(run, result, static_cast<std::int64_t>(steady_us()));
  });
  reload_rules();
  look_for_damaged();
}

Daemon::~Daemon() {
  control_.reset();
  notifier_.reset();
  sd_event_source_unref(receiver_source_);
  sd_event_source_unref(tick_source_);
  sd_event_unref(event_);
}

int Daemon::run() {
  started_us_ = steady_us();
  diagnosis_->take_up(static_cast<std::int64_t>(started_us_));
  check(sd_event_default(&event_), "create");
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  const auto on_signal = [](sd_event_source*, const signalfd_siginfo* info, void* self) {
    auto* daemon = static_cast<Daemon*>(self);
    return guarded(daemon->event_, [&] { daemon->on_signal(static_cast<int>(info->ssi_signo)); });
  };
  for (const int signal : {SIGTERM, SIGINT, SIGHUP})
    check(sd_event_add_signal(event_, nullptr, signal, on_signal, this), "signal");
  const auto on_tick = [](sd_event_source* source, std::uint64_t, void* self) {
    sd_event_source_set_time_relative(source, kTickUs);
    sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
    auto* daemon = static_cast<Daemon*>(self);
    return guarded(daemon->event_, [&] { daemon->on_tick(); });
  };
  check(sd_event_add_time_relative(event_, &tick_source_, CLOCK_MONOTONIC, kTickUs, 1000, on_tick, this),
        "timer");
  check(sd_event_set_watchdog(event_, 1), "watchdog");
  log_line(Priority::kInfo, "ballbard " + std::string(kVersion) + ": " +
                                std::to_string(service_->config().robots.size()) + " robots, database " +
                                store_->path() + ", bus " + service_->config().bus_url);
  open_publisher();
  open_control();
  notifier_->configure(service_->config().notify, event_);
  start_receiver();
  return sd_event_loop(event_);
}

void Daemon::start_receiver() {
  receiver_source_ = sd_event_source_unref(receiver_source_);
  listening_ = false;
  restart_at_us_ = 0;
  receiver_started_us_ = steady_us();
  try {
    receiver_->start();
  } catch (const Error& error) {  // no process, no memory: the world may have some again later
    last_error_ = error.what();
    log_line(Priority::kError, std::string(error.what()) + "; tried again");
    restart_at_us_ = steady_us() + kReceiverRetryUs;
    return;
  }
  const auto on_frames = [](sd_event_source*, int, std::uint32_t, void* self) {
    auto* daemon = static_cast<Daemon*>(self);
    return guarded(daemon->event_, [&] { daemon->on_receiver(kFramesPerTurn); });
  };
  check(sd_event_add_io(event_, &receiver_source_, receiver_->fd(), EPOLLIN, on_frames, this), "receiver");
}

/// Faster than runs are analysed nobody is heard: what comes meanwhile is lost in the network's buffers, and
/// counted in the run that it belongs to, instead of pushing out runs that wait.
bool Daemon::is_behind() const { return service_->waiting() > kMostBehind && !service_->stuck(); }

/// @return how many frames were read
int Daemon::on_receiver(int most_frames) {
  if (is_behind()) {
    service_->retry(kTurnUs);
    return 0;
  }
  int frames = 0;
  const bool alive = receiver_->read(
      [this, &frames](const ReceiverFrame& frame, std::span<const std::uint8_t> bytes) {
        ++frames;
        on_frame(frame, bytes);
      },
      most_frames);
  take_finished();
  if (!alive) receiver_gone();
  return frames;
}

void Daemon::on_frame(const ReceiverFrame& frame, std::span<const std::uint8_t> bytes) {
  unheard_ = 0;
  switch (frame.kind) {
    case ReceiverFrame::Kind::kPulse:
      break;
    case ReceiverFrame::Kind::kMessage: {
      const Decoded decoded = decode(frame.channel, bytes);
      if (const Refusal* reason = std::get_if<Refusal>(&decoded)) {
        assembler_->refuse(*reason);
        count_refusal(*reason, channel_name(frame.channel));
        break;
      }
      const std::int64_t refused = assembler_->counters().refused_total();
      const Sample& sample = std::get<Sample>(decoded);
      assembler_->take(sample, static_cast<std::int64_t>(steady_us()), finished_);
      if (assembler_->counters().refused_total() != refused) {
        const auto& header =
            std::visit([](const auto& s) -> const SampleHeader& { return s.header; }, sample);
        count_refusal(assembler_->last_refusal(),
                      std::string(channel_name(frame.channel)) + " of robot '" + header.robot + "'");
      }
      break;
    }
    case ReceiverFrame::Kind::kRefused:
      assembler_->refuse(frame.reason);
      count_refusal(frame.reason, channel_name(frame.channel));
      break;
    case ReceiverFrame::Kind::kDrops:
      kernel_drops_ = kernel_drops_before_ + frame.number;
      say_seldom("drops", "the socket's buffer was full: " + std::to_string(kernel_drops_) +
                              " datagrams lost so far; raise net.core.rmem_max (see README)");
      break;
    case ReceiverFrame::Kind::kListening:
      listening_ = true;
      bus_error_.clear();
      if (said_.insert("listening").second)
        log_line(Priority::kInfo, "listening on " + service_->config().bus_url);
      if (!ready_) sd_notify(0, "READY=1");
      ready_ = true;
      open_publisher();
      service_->publish_active_alarms();
      notify_status();
      break;
    case ReceiverFrame::Kind::kFailed: {
      const std::string why(bytes.begin(), bytes.end());
      if (why != bus_error_) log_line(Priority::kWarning, "waiting for the network: " + why);
      bus_error_ = why;
      said_.erase("listening");
      break;
    }
  }
}

void Daemon::receiver_gone() {
  receiver_source_ = sd_event_source_unref(receiver_source_);
  receiver_->stop();
  kernel_drops_before_ = kernel_drops_;
  if (!listening_) {
    if (bus_error_.empty()) {  // it has not even said that there is no network
      ++receiver_restarts_;
      say_seldom("receiver", "the receiver died before it could listen; it is started again");
    }
    restart_at_us_ = steady_us() + kReceiverRetryUs;
    return;
  }
  count_hole("the receiver died and is started again");
  if (steady_us() - receiver_started_us_ > kReceiverShortUs) return start_receiver();
  listening_ = false;  // somebody kills it again and again: not so fast
  restart_at_us_ = steady_us() + kReceiverPauseUs;
}

void Daemon::count_hole(const std::string& why) {
  ++receiver_restarts_;
  assembler_->receiver_restarted();
  say_seldom("receiver", why + " (" + std::to_string(receiver_restarts_) +
                             " times so far); the run in progress has a hole");
}

void Daemon::take_finished() {
  for (BaselineMark& mark : assembler_->calibrations()) service_->on_calibration(std::move(mark));
  for (Run& run : finished_) service_->enqueue(std::move(run));
  finished_.clear();
  if (service_->waits() && !service_->stuck()) service_->retry(kTurnUs);
}

void Daemon::on_tick() {
  const std::uint64_t now = steady_us();
  for (int frames = 0; receiver_source_ && frames < kFramesPerTick; frames += kFramesPerTurn)
    if (on_receiver(kFramesPerTurn) < kFramesPerTurn) break;  // what waits is older than this tick
  assembler_->tick(static_cast<std::int64_t>(now), finished_);
  take_finished();
  diagnosis_->tick(static_cast<std::int64_t>(now));
  if (restart_at_us_ != 0 && now >= restart_at_us_) start_receiver();
  if (!ready_ && now - started_us_ > kReadyAnywayUs) {
    ready_ = true;
    sd_notify(0, "READY=1");
  }
  notifier_->tick(now);
  if (++ticks_ % kTicksPerSecond == 0) on_second();
}

void Daemon::on_second() {
  const std::uint64_t second = ticks_ / kTicksPerSecond;
  if (second % kRetryStoreSeconds == 0) service_->retry(kTurnUs);
  service_->alarms().tick(wall_us());
  if (service_->store_damaged() || store_->database().damaged()) replace_damaged_store();
  for (const std::string& said :
       housekeeping_.on_second(*store_, service_->config(), status(), assembler_->counters().refused))
    log_line(Priority::kNotice, said);
  if (second % kForgetRefusalsSeconds == 0) sum_up_refusals();
  const std::int64_t ahead_us = wall_us() - static_cast<std::int64_t>(steady_us());
  if (std::abs(ahead_us - std::exchange(wall_ahead_us_, ahead_us)) > kClockWasSetUs) service_->on_clock_set();
  if (second % kJudgeTimeSeconds == 0) service_->on_time(wall_us());
  if (!service_->publisher() && listening_) open_publisher();
  if (second % kRepeatAlarmsSeconds == 0) {
    service_->publish_active_alarms();
  }
  publish_status();
  if (second % kStatusSeconds == 0) {
    look_for_damaged();
    notify_status();
  }
}

void Daemon::open_publisher() {
  if (service_->publisher()) return;
  try {
    service_->publish_to(std::make_unique<Publisher>(service_->config().bus_url));
  } catch (const Error& error) {
    last_error_ = error.what();  // the receiver meets the same network and says so
  }
}

void Daemon::open_control() {
  const auto answered = [](void* self, const std::string& request, const Peer& peer) {
    return answer(static_cast<Daemon*>(self)->service_->alarms(), request, peer, wall_us());
  };
  try {
    control_ = std::make_unique<ControlSocket>(event_, service_->config().control_socket, answered, this);
  } catch (const Error& error) {  // to measure and to judge, nobody need answer
    last_error_ = error.what();
    log_line(Priority::kWarning, "alarms can be neither acknowledged nor shelved: " + last_error_);
  }
}

void Daemon::on_signal(int signal) {
  if (signal == SIGHUP) return reload();
  stop();
}

void Daemon::reload() {
  sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%llu", static_cast<unsigned long long>(steady_us()));
  try {
    Config config = load_config(service_->config().path);
    Models models = load_models(config);
    if (config.store_path != service_->config().store_path)
      throw Error(Cause::kInput,
                  config.path + ": another [store] path needs a restart: systemctl restart ballbard");
    if (config.bus_url != service_->config().bus_url)
      throw Error(Cause::kInput,
                  config.path + ": another [bus] url needs a restart: systemctl restart ballbard");
    if (config.control_socket != service_->config().control_socket)
      throw Error(Cause::kInput,
                  config.path + ": another [control] socket needs a restart: systemctl restart ballbard");
    assembler_->configure(config.robots, recogniser_of(models), finished_);
    take_finished();
    if (!service_->stuck()) service_->retry(kBeforeReloadUs);  // they were measured with the old one
    service_->configure(std::move(config), std::move(models));
    notifier_->configure(service_->config().notify, event_);
    log_line(Priority::kNotice,
             "configuration read again: " + std::to_string(service_->config().robots.size()) + " robots");
  } catch (const std::exception& error) {  // whatever it is: the running configuration goes on measuring
    last_error_ = error.what();
    log_line(Priority::kError, "configuration kept as it was: " + last_error_);
  }
  reload_rules();
  sd_notify(0, "READY=1");
  notify_status();
}

void Daemon::reload_rules() {
  std::optional<RuleKeeper::Taken> taken = rule_keeper_->load(service_->config(), wall_us());
  if (taken) service_->replace_rules(std::move(taken->rules), taken->complete, wall_us());
  const std::string why_not = rule_keeper_->why_not();
  if (!why_not.empty()) last_error_ = why_not;
  service_->alarms().own(kRulesAlarm, !why_not.empty(), why_not, wall_us());
}

void Daemon::stop() {
  sd_notify(0, "STOPPING=1");
  diagnosis_->stop();
  receiver_source_ = sd_event_source_unref(receiver_source_);
  if (listening_)  // what has arrived before the signal is still taken
    receiver_->drain(
        [this](const ReceiverFrame& frame, std::span<const std::uint8_t> bytes) { on_frame(frame, bytes); },
        kDrainUs);
  receiver_->stop();
  assembler_->close_all(RunEnd::kInterrupted, finished_);
  take_finished();
  for (const std::uint64_t begin = steady_us();
       !service_->unstored().empty() && steady_us() - begin < kLastRetriesUs;) {
    sd_notify(0, "WATCHDOG=1");
    service_->retry(kTurnUs);
    if (!service_->unstored().empty()) usleep(100'000);
  }
  if (const std::string unstored = service_->unstored(); !unstored.empty())
    log_line(Priority::kError, unstored + " could not be stored and are lost");
  log_line(Priority::kInfo, "stopped: " + std::to_string(service_->counters().runs_stored) + " runs stored");
  sd_event_exit(event_, 0);
}

}  // namespace ballbar

#pragma once
/// A real ballbard on a private loopback, and what it says on the bus.

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <atomic>
#include <ballbar/alarm_t.hpp>
#include <ballbar/circle_result_t.hpp>
#include <ballbar/daemon_status_t.hpp>
#include <ballbar/gap_result_t.hpp>
#include <ballbar/line_result_t.hpp>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "support/private_network.hpp"
#include "support/process.hpp"

namespace ballbar::test {

/// For what must come: a wait ends as soon as it is there, and this is for machines that are slow and busy.
inline constexpr int kPatienceS = 60;

inline const std::string kLiveUrl = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";

/// Hears what the daemon publishes.
class Listener {
 public:
  Listener() : lcm_(kLiveUrl) {
    if (!lcm_.good() || lcm_.getFileno() < 0)
      throw std::runtime_error("no multicast on the private loopback");
    lcm_.subscribe("BALLBARD_STATUS", &Listener::on_status, this)->setQueueCapacity(1000);
    lcm_.subscribe("CIRCLE_RESULT", &Listener::on_circle, this)->setQueueCapacity(1000);
    lcm_.subscribe("LINE_RESULT", &Listener::on_line, this)->setQueueCapacity(1000);
    lcm_.subscribe("GAP_RESULT", &Listener::on_gap, this)->setQueueCapacity(1000);
    lcm_.subscribe("ALARM", &Listener::on_alarm, this)->setQueueCapacity(1000);
  }
  /// Listens until `done` or the time is over. @return done
  bool until(const std::function<bool()>& done, double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!done()) {
      if (std::chrono::steady_clock::now() > end) return false;
      pollfd ready{lcm_.getFileno(), POLLIN, 0};
      if (poll(&ready, 1, 100) > 0) lcm_.handle();
    }
    return true;
  }
  lcm::LCM& lcm() { return lcm_; }

  std::optional<daemon_status_t> status;
  std::vector<circle_result_t> circles;
  std::vector<line_result_t> lines;
  std::vector<alarm_t> alarms;
  std::vector<gap_result_t> gaps;

 private:
  void on_status(const lcm::ReceiveBuffer*, const std::string&, const daemon_status_t* m) { status = *m; }
  void on_circle(const lcm::ReceiveBuffer*, const std::string&, const circle_result_t* m) {
    circles.push_back(*m);
  }
  void on_line(const lcm::ReceiveBuffer*, const std::string&, const line_result_t* m) { lines.push_back(*m); }
  void on_alarm(const lcm::ReceiveBuffer*, const std::string&, const alarm_t* m) { alarms.push_back(*m); }

  void on_gap(const lcm::ReceiveBuffer*, const std::string&, const gap_result_t* m) { gaps.push_back(*m); }

  lcm::LCM lcm_;
};

/// The service manager's end of sd_notify. Reads all the time, as systemd does: a full socket would stop the
/// daemon.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path)
      : path_(path), fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    if (bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("bind " + path);
    reader_ = std::thread([this] { read(); });
  }
  ~NotifySocket() {
    stop_ = true;
    reader_.join();
    close(fd_);
  }
  /// Waits for the next message that holds `text`, behind those that earlier calls have found.
  bool until(const std::string& text, double seconds) {
    std::unique_lock lock(mutex_);
    const auto found = [&] {
      while (next_ < said_.size())
        if (said_[next_++].find(text) != std::string::npos) return true;
      return false;
    };
    return changed_.wait_for(lock, std::chrono::duration<double>(seconds), found);
  }
  const std::string& path() const { return path_; }

 private:
  void read() {
    while (!stop_) {
      pollfd ready{fd_, POLLIN, 0};
      if (poll(&ready, 1, 50) <= 0) continue;
      char buffer[4096];
      const ssize_t size = recv(fd_, buffer, sizeof buffer, 0);
      if (size <= 0) continue;
      const std::lock_guard lock(mutex_);
      said_.emplace_back(buffer, static_cast<std::size_t>(size));
      changed_.notify_all();
    }
  }

  std::string path_;
  int fd_ = -1;
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::string> said_;
  std::size_t next_ = 0;
  std::thread reader_;
};

/// ballbard with its own folder: configuration, rules, database.
class LiveDaemon {
 public:
  /// @param robots  the [[robot]] part of the configuration; URDF paths absolute
  /// @param db       the database; empty: in its own folder
  explicit LiveDaemon(const std::string& robots, const std::vector<std::string>& environment = {},
                      const std::string& db = "")
      : notify_(dir_.path() + "/notify"),
        environment_(environment),
        db_(db.empty() ? dir_.path() + "/ballbard.db" : db) {
    std::filesystem::create_directory(dir_.path() + "/rules.d");
    configure(robots);
    start();
  }
  /// Again, after kill() or stop(). Its log begins anew.
  void start() {
    std::vector<std::string> variables = environment_;
    variables.push_back("NOTIFY_SOCKET=" + notify_.path());
    process_ = std::make_unique<Background>(std::vector<std::string>{kBallbard, "--config", config()},
                                            dir_.path() + "/ballbard", variables);
  }
  /// kill -9. @return exit code
  int kill() {
    process_->signal(SIGKILL);
    return process_->wait();
  }
  void configure(const std::string& robots) const {
    write_file(config(), "[bus]\nurl = \"" + kLiveUrl + "\"\n[store]\npath = \"" + db_ +
                             "\"\n[rules]\ndirectory = \"rules.d\"\n[control]\nsocket = \"control\"\n" +
                             robots);
  }
  bool ready() {
    for (int i = 0; i < 2 * kPatienceS; ++i) {
      if (notify_.until("READY=1", 0.5)) return true;
      if (!process_->alive()) return false;
    }
    return false;
  }
  NotifySocket& notify() { return notify_; }
  Background& process() { return *process_; }
  std::string config() const { return dir_.path() + "/ballbard.toml"; }
  const std::string& db() const { return db_; }
  std::string control() const { return dir_.path() + "/control"; }
  std::string path(const std::string& name) const { return dir_.path() + "/" + name; }
  std::string rules() const { return dir_.path() + "/rules.d"; }
  const std::string& folder() const { return dir_.path(); }
  std::string log() const { return process_->err(); }
  /// Waits until its log says `text`, or it has ended. @return whether it did
  bool says(const std::string& text) {
    for (int i = 0; i < 20 * kPatienceS; ++i) {
      const bool alive = process_->alive();
      if (log().find(text) != std::string::npos) return true;
      if (!alive) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }
  /// @return exit code
  int stop() {
    process_->signal(SIGTERM);
    return process_->wait();
  }
  std::string exported() const { return run({kBallbar, "export", "--json", "--db", db()}).out; }

 private:
  TempDir dir_;
  NotifySocket notify_;
  std::vector<std::string> environment_;
  std::string db_;
  std::unique_ptr<Background> process_;
};

/// Plays a log onto the bus from a second process. @return lcm-logplayer's exit code
inline int play(const std::string& log, double speed) {
  return run({"lcm-logplayer", "-s", std::to_string(speed), "-l", kLiveUrl, log}).code;
}

}  // namespace ballbar::test

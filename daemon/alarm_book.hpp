#pragma once
/// All alarms as they stand: those of rules, which runs move, and those about ballbard itself; and what
/// people do to them.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/alarm.hpp"
#include "daemon/log.hpp"
#include "store/store.hpp"

namespace ballbar {

/// Alarms about ballbard itself. They have no robot and no test.
inline constexpr const char* kRulesAlarm = "ballbard_rules";       ///< a set of rules that cannot be taken
inline constexpr const char* kNotifyAlarm = "ballbard_notify";     ///< the [notify] command fails
inline constexpr const char* kDamagedAlarm = "ballbard_database";  ///< a damaged database lies set aside

class AlarmBook {
 public:
  using Log = std::function<void(Priority, const std::string&)>;
  using Heard = std::function<void(const AlarmStatus&)>;

  /// Takes over what is stored. @param heard  is told each alarm that changed, after it was stored
  AlarmBook(Store& store, Log log, Heard heard);

  std::vector<AlarmStatus> states() const;
  int firing() const;
  /// @throws Error(kInput) where no alarm has this id
  const AlarmStatus& find(std::int64_t id) const;

  /// Gives alarms that are new their id, in both lists.
  void number(std::vector<AlarmStatus>& states, std::vector<AlarmEvent>& events) const;
  /// Alarms that a run has moved, after they were stored with it. Says their events.
  void moved(const std::vector<AlarmStatus>& states, const std::vector<AlarmEvent>& events);
  /// Alarms that were judged and stay what they are: not stored.
  void stand(const std::vector<AlarmStatus>& states);
  /// Alarms that no run has moved: stores them and says their events. Where the database cannot be written,
  /// they stand all the same, and retry() stores them.
  void change(const std::vector<AlarmStatus>& states, const std::vector<AlarmEvent>& events);

  /// An alarm about ballbard itself fires, or is over. Saying the same again changes nothing;
  /// other words are stored without an event.
  void own(const std::string& rule, bool bad, const std::string& text, std::int64_t now_us,
           const std::string& severity = "warning");

  // What people do. Nothing has happened where these throw: Error(kInput) where it makes no sense, StoreError
  // where it could not be stored.
  void acknowledge(std::int64_t id, const std::string& by, const std::string& comment, std::int64_t now_us);
  void shelve(std::int64_t id, std::int64_t until_us, const std::string& by, const std::string& comment,
              std::int64_t now_us);
  void unshelve(std::int64_t id, const std::string& by, const std::string& comment, std::int64_t now_us);

  /// Ends the shelvings whose time is over.
  void tick(std::int64_t now_us);
  /// Stores what could not be stored.
  void retry();
  std::size_t unsaved() const { return std::max(unsaved_.size(), unsaved_events_.size()); }

  /// Takes over what another program has stored since: ballbar replay, import and db recover move alarms too.
  void look();
  /// The store is another one, new and empty: what stands here is stored there.
  void on_new_store();

 private:
  void store_and_say(const AlarmStatus& status, const AlarmEvent& event);
  std::int64_t data_version() const;
  void say(const AlarmEvent& event) const;

  Store& store_;
  Log log_;
  Heard heard_;
  std::map<AlarmKey, AlarmStatus> alarms_;
  std::vector<AlarmStatus> unsaved_;
  std::vector<AlarmEvent> unsaved_events_;
  std::int64_t version_ = 0;  ///< of what is stored, as far as others have changed it
  std::string said_;          ///< about what waits
};

/// "ovality_high lrmate-1 A+1", "straightness_high lrmate-1 Y-1 Z", "ballbard_notify".
std::string alarm_name(const AlarmKey& key);

}  // namespace ballbar

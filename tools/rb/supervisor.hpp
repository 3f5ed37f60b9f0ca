#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "common/types/clocks.hpp"

namespace roadbalance {

/// When a supervised program is started, ended or given up; a pure state machine.
///
/// A program that fails is started again, at once the first time and then after ever longer waits, up to
/// `longest_wait`; one that has run for `good_run` is trusted again.  A program that is watched and is not
/// fed in time is killed: it hangs.  Exit codes 0, 2 (usage), 3 (ended, but samples are missing) and
/// 127 (no such program), which would come for ever, and every end after a request to stop, are final.
class Supervisor {
 public:
  static constexpr int kCannotExecute = 127;

  struct Options {
    std::optional<std::chrono::milliseconds> watchdog;  ///< nothing: a program may be silent
    /// For the first feeding after a start, which may be long with a large record; or `watchdog`, if that is
    /// longer.
    std::chrono::milliseconds start_limit{60'000};
    std::chrono::milliseconds first_wait{100};
    std::chrono::milliseconds longest_wait{10'000};
    std::chrono::milliseconds good_run{10'000};
  };
  enum class Act { kNone, kStart, kKill };

  explicit Supervisor(Options options) : options_(options) {}

  /// The action that is due now.
  Act due(WallTime now);
  /// Until something may be due.
  std::chrono::milliseconds time_left(WallTime now) const;

  void started(WallTime now);
  /// A datagram of the program's, sd_notify(3): "WATCHDOG=1" and "READY=1" feed, "STATUS=" is for people.
  void take(std::string_view message, WallTime now);
  /// @param code  exit code, 128 + signal if a signal ended it
  void ended(int code, WallTime now);
  /// A request to stop was passed on: the next end is final.
  void stop() { stopping_ = true; }

  /// Once it is over: the exit code.
  std::optional<int> over() const { return over_; }
  int restarts() const { return restarts_; }
  /// The newest STATUS= of the program.
  std::string_view status() const { return status_; }

 private:
  enum class State { kWaiting, kRunning, kKilled };
  WallTime hangs_at() const;

  const Options options_;
  State state_ = State::kWaiting;
  WallTime start_at_{};
  WallTime started_at_{};
  WallTime fed_at_{};
  bool fed_ = false;
  bool stopping_ = false;
  std::chrono::milliseconds wait_{0};
  std::optional<int> over_;
  int restarts_ = 0;
  std::string status_;
};

}  // namespace roadbalance

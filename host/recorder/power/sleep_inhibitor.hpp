#pragma once

#include <string>

namespace roadbalance {

/// Keeps this computer from going to sleep by itself, or when its lid is closed, as long as it lives: a lock
/// of systemd's logind, of mode block (org.freedesktop.login1, Inhibit).
class SleepInhibitor {
 public:
  /// Asks for it; waits at most a second for each of two answers.
  SleepInhibitor();
  SleepInhibitor(const SleepInhibitor&) = delete;
  SleepInhibitor& operator=(const SleepInhibitor&) = delete;
  ~SleepInhibitor();

  /// For people: why there is no lock; empty: there is one.
  const std::string& refusal() const { return refusal_; }

 private:
  int lock_ = -1;
  std::string refusal_;
};

}  // namespace roadbalance

#pragma once

#include <chrono>
#include <string>

#include "common/clock/clocks.hpp"

namespace roadbalance {

/// Why a device that went cannot be had again: worth a word once it has been the same for two seconds.
/// What comes and goes faster is the system that sets the device up.
class LastingReason {
 public:
  /// @param why  it could not be had just now
  /// @return true once for each lasting reason: say it
  [[nodiscard]] bool is_to_be_said(const std::string& why, WallTime now) {
    if (why != why_) {
      why_ = why;
      since_ = now;
      said_ = false;
    }
    if (said_ || now - since_ < kPatience) return false;
    return said_ = true;
  }
  /// The device is there.
  void over() { why_.clear(); }

 private:
  static constexpr auto kPatience = std::chrono::seconds(2);
  std::string why_;  ///< empty: it was there
  WallTime since_{};
  bool said_ = false;
};

}  // namespace roadbalance

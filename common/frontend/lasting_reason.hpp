#pragma once

#include <chrono>
#include <string>

#include "common/types/clocks.hpp"

namespace roadbalance {

/// Why a device that went cannot be had again: reported once it has been the same for two seconds. A reason
/// that comes and goes faster is the system that sets the device up.
class LastingReason {
 public:
  /// @param why  it could not be had just now
  /// @return true once for each lasting reason: report it
  [[nodiscard]] bool is_due(const std::string& why, WallTime now) {
    if (why != why_) {
      why_ = why;
      since_ = now;
      reported_ = false;
    }
    if (reported_ || now - since_ < kPatience) return false;
    return reported_ = true;
  }
  /// The device is there.
  void over() { why_.clear(); }

 private:
  static constexpr auto kPatience = std::chrono::seconds(2);
  std::string why_;  ///< empty: it was there
  WallTime since_{};
  bool reported_ = false;
};

}  // namespace roadbalance

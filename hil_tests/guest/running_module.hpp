#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "hil_tests/guest/can_player.hpp"

namespace roadbalance::test {

/// An accelerometer module that converts a thousand times a second until its end.
class RunningModule {
 public:
  static constexpr std::uint32_t kFirstId = 0x200;

  /// @param interface  of the module's end of the cable
  /// @throws std::system_error
  explicit RunningModule(const std::string& interface);

  /// So many conversions never reach the bus.
  void lose(std::uint32_t conversions) { lost_ += conversions; }

 private:
  void run(const std::stop_token& stop);

  CanPlayer player_;
  std::atomic<std::uint32_t> lost_ = 0;
  std::jthread thread_;
};

}  // namespace roadbalance::test

#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "hil_tests/guest/accelerometer_module.hpp"

namespace roadbalance::test {

/// An accelerometer module that converts a thousand times a second until its end.
class RunningModule {
 public:
  /// @param interface  of the module's end of the cable
  /// @throws std::system_error
  explicit RunningModule(const std::string& interface);

  /// As [[node.can]] of a node that hears it at this interface.
  static std::string wiring(const std::string& interface);

  /// So many conversions never reach the bus.
  void lose(std::uint32_t conversions) { lost_ += conversions; }

 private:
  void run(const std::stop_token& stop);

  AccelerometerModule module_;
  std::atomic<std::uint32_t> lost_ = 0;
  std::jthread thread_;
};

}  // namespace roadbalance::test

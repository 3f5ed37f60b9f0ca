#pragma once

#include <cstdint>
#include <string>

#include "hil_tests/guest/can_player.hpp"

namespace roadbalance::test {

/// A CAN accelerometer module at the other end of the cable: a conversion a call, numbered on.
/// Channel k of number n is n + 1000 k, in 16 bits.
class AccelerometerModule {
 public:
  static constexpr std::uint32_t kFirstId = 0x200;

  /// @param interface  of the module's end of the cable
  /// @param is_fd   sends CAN FD
  /// @throws std::system_error
  AccelerometerModule(const std::string& interface, bool is_fd) : player_(interface), is_fd_(is_fd) {}

  void convert();
  /// So many conversions never reach the bus.
  void skip(std::uint32_t conversions) { number_ += conversions; }

 private:
  CanPlayer player_;
  bool is_fd_;
  std::uint32_t number_ = 0;
};

}  // namespace roadbalance::test

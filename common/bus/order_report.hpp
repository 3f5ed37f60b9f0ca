#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "common/types/scan.hpp"

namespace roadbalance {

inline constexpr const char* kOrdersChannel = "RB_ORDERS";

/// Vibration that turns with a wheel, in the channels of one node, over the drive so far; fields as in
/// common/wire/orders_t.
struct OrderReport {
  static constexpr std::size_t kOrders = 2;  ///< first and second
  struct Vector {
    std::complex<double> value;
    double amplitude_95 = std::numeric_limits<double>::quiet_NaN();
    double phase_95_rad = std::numeric_limits<double>::quiet_NaN();
    std::int32_t blocks = 0;
  };
  std::int32_t wheel = 0;
  std::int32_t node = 0;
  std::int64_t time_ns = 0;
  double seconds = 0.0, no_angle_s = 0.0;
  std::array<std::array<Vector, kAccelerations>, kOrders> order{};  ///< [order 1, 2][channel]
};

std::vector<std::uint8_t> encode(const OrderReport& report);
std::optional<OrderReport> decode_orders(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance

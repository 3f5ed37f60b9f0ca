#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/bus/transfer_function_report.hpp"

namespace roadbalance {

/// Messages that a display draws beside results; fields as in common/wire.

inline constexpr const char* kEnvelopeChannel = "RB_ENVELOPE";
inline constexpr const char* kWaterfallChannel = "RB_WATERFALL";

inline constexpr std::size_t kMostBuckets = 96;
struct Envelope {
  std::int32_t node = 0, channel = 0;
  std::int64_t epoch = 0;
  std::int64_t first = 0;   ///< number of the first bucket
  std::int32_t scans = 10;  ///< in a bucket
  std::int64_t time_ns = 0;
  std::int64_t period_ps = 0;
  struct Bucket {
    float least = 0.0F, greatest = 0.0F;  ///< m/s^2; NaN: not all of its scans came
  };
  std::vector<Bucket> bucket{};  ///< at most kMostBuckets
};

/// Why there is no order spectrum (yet).
enum class OrderState : std::int32_t {
  kComputed = 0,
  kTooShort = 1,   ///< no block of turns is full yet: too slow, or the wheel's angle is not known
  kNoChannel = 2,  ///< the vehicle has no such channel in use, or the wheel no encoder
  kTooMuch = 3,    ///< more than the analyser computes at a time
};

inline constexpr std::size_t kMostWaterfallLines = 272;
struct WaterfallRow {
  WheelChannel of{};
  std::int64_t time_ns = 0;
  OrderState state = OrderState::kComputed;
  std::int32_t speed_class = 0;
  double from_m_s = 0.0, to_m_s = 0.0;
  double way_m = 0.0;
  std::int32_t blocks = 0;
  double step = 0.0, noise_bandwidth = 0.0;
  std::vector<float> amplitude{};  ///< at most kMostWaterfallLines
};

std::vector<std::uint8_t> encode(const Envelope& message);
std::vector<std::uint8_t> encode(const WaterfallRow& message);
std::optional<Envelope> decode_envelope(std::span<const std::uint8_t> bytes);
std::optional<WaterfallRow> decode_waterfall(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// A sample this close to full scale is taken as clipped.
inline constexpr double kClipped = 0.999;

/// What is strange about an acceleration channel: an offset that gravity cannot explain, no signal, clipping.
/// Nothing is corrected.
class ChannelSuspicion {
 public:
  /// @param channel  outlives this
  ChannelSuspicion(const ChannelConfig& channel, double rate_hz);

  /// The next of uniform samples; NaN: there is none.
  void add(double value_m_s2);
  /// Each as a clause in English: "is constant during 3 of 10 s".
  std::vector<std::string> found() const;

 private:
  void end_second();

  const ChannelConfig& channel_;
  const std::int64_t samples_a_second_;
  std::int64_t samples_ = 0;
  double mean_ = 0.0, squares_ = 0.0;  ///< of the present second; squares about its mean
  std::int64_t seconds_ = 0, constant_ = 0, offset_ = 0, clipped_ = 0;
  double sum_offset_ = 0.0;
};

}  // namespace roadbalance

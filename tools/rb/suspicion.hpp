#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// A sample this close to full scale is taken as clipped.
inline constexpr double kClipped = 0.999;

/// What is strange about an acceleration channel, each as a clause: an offset that gravity cannot explain, no
/// signal, clipping.  Nothing is corrected.
/// @param value_m_s2  uniform samples at rate_hz
std::vector<std::string> suspicions_of(std::span<const double> value_m_s2, const ChannelConfig& channel,
                                       double rate_hz);

}  // namespace roadbalance

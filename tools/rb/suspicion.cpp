#include "tools/rb/suspicion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/vehicle/gravity.hpp"

namespace roadbalance {

namespace {

constexpr double kMostOffset_m_s2 =
    2.0 * kStandardGravity_m_s2;             // gravity is 1 g, no road gives a second's mean of another
constexpr double kLeastSpread_counts = 0.5;  // less is not even quantisation noise

template <typename... Values>
std::string text(const char* format, Values... values) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

}  // namespace

std::vector<std::string> suspicions_of(std::span<const double> value_m_s2, const ChannelConfig& channel,
                                       double rate_hz) {
  std::vector<std::string> found;
  const auto second = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(rate_hz)));
  std::size_t seconds = 0, constant = 0, offset = 0, clipped = 0;
  double sum_offset = 0.0;
  for (std::size_t begin = 0; begin + second <= value_m_s2.size(); begin += second) {
    const auto part = value_m_s2.subspan(begin, second);
    double mean = 0.0, square = 0.0;
    for (const double v : part) mean += v / static_cast<double>(second);
    for (const double v : part) square += (v - mean) * (v - mean) / static_cast<double>(second);
    ++seconds;
    if (std::sqrt(square) < kLeastSpread_counts * channel.scale_m_s2_per_count) ++constant;
    if (std::abs(mean) > kMostOffset_m_s2) {
      ++offset;
      sum_offset += mean;
    }
  }
  for (const double v : value_m_s2) clipped += std::abs(v) >= kClipped * channel.range_m_s2 ? 1 : 0;

  if (offset > 0)
    found.push_back(text("sits at %.1f g on average during %zu of %zu s: more than gravity",
                         sum_offset / static_cast<double>(offset) / kStandardGravity_m_s2, offset, seconds));
  if (constant > 0) found.push_back(text("is constant during %zu of %zu s", constant, seconds));
  if (clipped > 0) found.push_back(text("reaches its full scale in %zu samples", clipped));
  return found;
}

}  // namespace roadbalance

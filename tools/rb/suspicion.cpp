#include "tools/rb/suspicion.hpp"

#include <algorithm>
#include <cmath>

#include "common/text/format.hpp"
#include "common/vehicle/gravity.hpp"

namespace roadbalance {

namespace {

constexpr double kMostOffset_m_s2 =
    2.0 * kStandardGravity_m_s2;             // gravity is 1 g, no road gives a second's mean of another
constexpr double kLeastSpread_counts = 0.5;  // less is not even quantisation noise

}  // namespace

ChannelSuspicion::ChannelSuspicion(const ChannelConfig& channel, double rate_hz)
    : channel_(channel), samples_a_second_(std::max<std::int64_t>(1, std::llround(rate_hz))) {}

void ChannelSuspicion::add(double value_m_s2) {
  if (std::abs(value_m_s2) >= kClipped * channel_.range_m_s2) ++clipped_;
  ++samples_;
  const double off = value_m_s2 - mean_;
  mean_ += off / static_cast<double>(samples_);
  squares_ += off * (value_m_s2 - mean_);
  if (samples_ == samples_a_second_) end_second();
}

void ChannelSuspicion::end_second() {
  ++seconds_;
  if (std::sqrt(squares_ / static_cast<double>(samples_)) <
      kLeastSpread_counts * channel_.scale_m_s2_per_count)
    ++constant_;
  if (std::abs(mean_) > kMostOffset_m_s2) {
    ++offset_;
    sum_offset_ += mean_;
  }
  samples_ = 0;
  mean_ = squares_ = 0.0;
}

std::vector<std::string> ChannelSuspicion::found() const {
  std::vector<std::string> found;
  const std::string of_seconds = " of " + std::to_string(seconds_) + " s";
  if (offset_ > 0) {
    const double mean_g = sum_offset_ / static_cast<double>(offset_) / kStandardGravity_m_s2;
    found.push_back("sits at " + format("%.1f", mean_g) + " g on average during " + std::to_string(offset_) +
                    of_seconds + ": more than gravity");
  }
  if (constant_ > 0) found.push_back("is constant during " + std::to_string(constant_) + of_seconds);
  if (clipped_ > 0) found.push_back("reaches its full scale in " + std::to_string(clipped_) + " samples");
  return found;
}

}  // namespace roadbalance

#include "host/analysis/orders/si_channels.hpp"

namespace roadbalance {

SiChannels::SiChannels(const NodeConfig& node, const std::vector<std::size_t>& channel) {
  for (const std::size_t place : channel) {
    const ChannelConfig& config = node.channel[place];
    channel_.push_back({place, config.offset_counts, config.scale_m_s2_per_count});
  }
}

std::uint32_t SiChannels::read(const GridJoin::Sample& sample, Eigen::Ref<Eigen::VectorXd> values) const {
  const float* const counts = sample.counts->data();
  double* value = values.data();
  for (const Channel& of : channel_)
    *value++ = (static_cast<double>(counts[of.place]) - of.offset_counts) * of.scale;
  std::uint32_t overload = 0;
  if (sample.overload != 0)
    for (std::size_t c = 0; c < channel_.size(); ++c)
      overload |= static_cast<std::uint32_t>(sample.overload >> channel_[c].place & 1) << c;
  return overload;
}

}  // namespace roadbalance

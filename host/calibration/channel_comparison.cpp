#include "host/calibration/channel_comparison.hpp"

#include <algorithm>
#include <stdexcept>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

constexpr std::array kReferenceNames{"reference_13", "reference_14", "reference_15", "reference_16"};

}  // namespace

ChannelComparison::ChannelComparison(const NodeConfig& node, const Settings& settings)
    : node_(node), settings_(settings) {
  for (std::size_t c = 0; c < node.channel.size(); ++c)
    if (node.channel[c].role != ChannelRole::kUnused) input_.push_back(input_of(node.channel[c], c));
  if (node.wiring.loop_back)
    for (std::size_t r = 0; r < kReferences; ++r)
      input_.push_back({kReferenceNames[r], kAccelerations + r, 1.0, 0.0, 0.0, 0.0, true});
  const bool known =
      std::ranges::any_of(input_, [&](const Input& in) { return in.name == settings.reference; });
  if (!settings.reference.empty() && !known)
    throw ConfigError("node " + node.name + " has no channel \"" + settings.reference + "\" in use");
  try {
    spectra_.emplace(CrossSpectra::Settings{static_cast<int>(input_.size()), node.rate_hz, settings.segment_s,
                                            settings.low_hz, settings.high_hz});
  } catch (const std::invalid_argument& error) {
    throw ConfigError("node " + node.name + ": " + error.what());
  }
  sample_.resize(input_.size());
}

ChannelComparison::Input ChannelComparison::input_of(const ChannelConfig& channel, std::size_t place) const {
  if (settings_.motion)
    return {channel.name,
            place,
            channel.scale_m_s2_per_count,
            channel.scale_m_s2_per_count,
            channel.delay_s,
            channel.offset_counts,
            false};
  const auto other = std::ranges::find_if(node_.channel, [&](const ChannelConfig& one) {
    return one.role != ChannelRole::kUnused &&
           one.input_range_v.has_value() != channel.input_range_v.has_value();
  });
  if (other != node_.channel.end())
    throw ConfigError("node " + node_.name + ": input_range_v: given for some channels and not for others (" +
                      channel.name + ", " + other->name + "): their voltages cannot be compared");
  return {channel.name,
          place,
          channel.input_range_v.value_or(1.0),
          channel.range_m_s2 / kFullScaleCounts,
          channel.delay_s,
          channel.offset_counts,
          false};
}

void ChannelComparison::add(const ScanBlock& block) {
  const bool follows = block.header.epoch == epoch_ && block.header.first_scan == next_scan_;
  epoch_ = block.header.epoch;
  next_scan_ = block.header.first_scan + block.header.scans;
  if (!follows) spectra_->interrupt();
  if (block.overload != 0) return spectra_->interrupt();
  for (std::int64_t r = 0; r < block.header.scans; ++r) {
    const auto& counts = block.counts[static_cast<std::size_t>(r)];
    for (std::size_t i = 0; i < input_.size(); ++i)
      sample_[i] = input_[i].per_count * counts[input_[i].place];
    spectra_->add(sample_);
  }
  scans_ += block.header.scans;
}

/// Something was fed to the converters of the references, too.
bool ChannelComparison::loops_back() const {
  return std::ranges::any_of(input_, &Input::reference);
}

ChannelComparison::Result ChannelComparison::result() const {
  std::vector<int> accelerations, delays;
  for (std::size_t i = 0; i < input_.size(); ++i) {
    const bool named = settings_.reference.empty() || input_[i].name == settings_.reference;
    if (named && !input_[i].reference) accelerations.push_back(static_cast<int>(i));
    if (named && input_[i].reference) delays.push_back(static_cast<int>(i));
  }
  Result result{{}, static_cast<double>(scans_) / node_.rate_hz};
  auto by_gain = match_channels(*spectra_, accelerations);
  auto by_delay = loops_back() ? match_channels(*spectra_, delays) : std::nullopt;
  if (!by_delay) by_delay = by_gain;  // the loop-back was not given the signal
  if (!by_gain) by_gain = by_delay;
  if (!by_gain) return result;
  const auto named = std::ranges::find(input_, settings_.reference, &Input::name);
  // What stays as it is has the delay that it was given before; nobody compares that one.
  const double stays_s = named == input_.end() ? 0.0 : named->present_delay_s;
  for (std::size_t i = 0; i < input_.size(); ++i) {
    Channel channel{input_[i].name, (*by_delay)[i]};
    channel.match.gain = (*by_gain)[i].gain;
    channel.match.gain_sigma = (*by_gain)[i].gain_sigma;
    channel.can_be_set = !input_[i].reference && channel.match.verdict == ChannelMatch::Verdict::kMatched;
    if (channel.can_be_set) {
      channel.scale_m_s2_per_count = input_[i].base_scale / channel.match.gain;
      channel.offset_counts = input_[i].offset_counts;
      channel.delay_s = stays_s + channel.match.delay_s;
    }
    result.channel.push_back(channel);
  }
  return result;
}

}  // namespace roadbalance

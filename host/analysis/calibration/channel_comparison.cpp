#include "host/analysis/calibration/channel_comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
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
  if (node.wiring.loop_back && !settings.motion)
    for (std::size_t r = 0; r < kReferences; ++r)
      input_.push_back({kReferenceNames[r], kAccelerations + r, 1.0, 0.0, 0.0, 0.0, true});
  for (const Input& input : input_) compared_ |= 1 << input.place;
  if (!has_reference(node, settings))
    throw ConfigError("node " + node.name + " has no channel \"" + settings.reference + "\" in use");
  const int segment = std::max(2, static_cast<int>(std::lround(settings.segment_s * node.rate_hz)));
  try {
    spectra_.emplace(CrossSpectra::Settings{.welch = {.rate_hz = node.rate_hz, .segment = segment},
                                            .channels = static_cast<int>(input_.size()),
                                            .remove_means = true});
  } catch (const std::invalid_argument& error) {
    throw ConfigError("node " + node.name + ": " + error.what());
  }
  if (const auto band = spectra_in_band(*spectra_, settings.low_hz, settings.high_hz);
      band.frequency_hz.empty() || band.frequency_hz.front() == 0.0)
    throw ConfigError("node " + node.name + ": cross spectra: no bin lies within the band");
}

bool ChannelComparison::has_reference(const NodeConfig& node, const Settings& settings) {
  const std::string& name = settings.reference;
  const bool loop_back = node.wiring.loop_back && !settings.motion;
  return name.empty() || (loop_back && std::ranges::find(kReferenceNames, name) != kReferenceNames.end()) ||
         std::ranges::any_of(node.channel, [&](const ChannelConfig& channel) {
           return channel.role != ChannelRole::kUnused && channel.name == name;
         });
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
  if (!follows) spectra_->gap();
  if ((block.overload & compared_) != 0) {
    overloaded_ += block.header.scans;
    return spectra_->gap();
  }
  samples_.resize(static_cast<Eigen::Index>(input_.size()), block.header.scans);
  for (std::int64_t r = 0; r < block.header.scans; ++r) {
    const auto& counts = block.counts[static_cast<std::size_t>(r)];
    for (std::size_t i = 0; i < input_.size(); ++i)
      samples_(static_cast<Eigen::Index>(i), r) = input_[i].per_count * counts[input_[i].place];
  }
  spectra_->add(samples_);
  scans_ += block.header.scans;
}

/// Something was fed to the converters of the references, too.
bool ChannelComparison::loops_back() const {
  return std::ranges::any_of(input_, &Input::reference);
}

std::string ChannelComparison::text_of(ChannelMatches::Reason refusal) const {
  char text[200];
  switch (refusal) {
    case ChannelMatches::Reason::kNone:
      return {};
    case ChannelMatches::Reason::kTooShort:
      std::snprintf(text, sizeof text,
                    "%.0f s could be compared; the signal must be there for %.0f s at least (--segment-s)",
                    static_cast<double>(scans_) / node_.rate_hz, least_s());
      return text;
    case ChannelMatches::Reason::kNoTwoAlike:
      return "no two channels show the same signal";
    case ChannelMatches::Reason::kReference:
      return (settings_.reference.empty() ? "the accelerations do" : settings_.reference + " does") +
             std::string(" not show the signal as the other channels do, and cannot be the reference");
  }
  return {};
}

/// Median of the gains of what is matched; 0: nothing is.
double ChannelComparison::size_of(const std::vector<ChannelMatch>& all, bool reference) const {
  std::vector<double> gains;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (input_[i].reference == reference && all[i].verdict == ChannelMatch::Verdict::kMatched)
      gains.push_back(all[i].gain);
  return gains.empty() ? 0.0 : median(gains);
}

/// Crosstalk of its neighbours alone is no signal; its range is not known.
bool ChannelComparison::loop_back_was_fed(const std::vector<ChannelMatch>& all) const {
  constexpr double kLeast = 0.05;
  const double accelerations = size_of(all, false), references = size_of(all, true);
  return references > 0.0 && references >= kLeast * accelerations / input_.front().per_count;
}

void ChannelComparison::doubt_other_sizes(std::vector<ChannelMatch>& all) const {
  const double usual = size_of(all, false);
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!input_[i].reference && all[i].verdict == ChannelMatch::Verdict::kMatched &&
        std::abs(all[i].gain / usual - 1.0) > kMostMismatch)
      all[i].verdict = ChannelMatch::Verdict::kOtherSize;
}

ChannelComparison::Result ChannelComparison::result() const {
  std::vector<int> accelerations, references;
  const auto named = std::ranges::find(input_, settings_.reference, &Input::name);
  for (std::size_t i = 0; i < input_.size(); ++i) {
    auto& kind = input_[i].reference ? references : accelerations;
    const bool counts =
        named == input_.end() || named->reference != input_[i].reference || &*named == &input_[i];
    if (counts) kind.push_back(static_cast<int>(i));
  }
  const auto seconds = [&](std::int64_t scans) { return static_cast<double>(scans) / node_.rate_hz; };
  Result result{.channel = {}, .seconds = seconds(scans_), .overload_s = seconds(overloaded_)};
  const BandSpectra band = spectra_in_band(*spectra_, settings_.low_hz, settings_.high_hz);
  ChannelMatches by_gain = match_channels(band, accelerations);
  result.refusal = text_of(by_gain.refusal);
  if (!result.refusal.empty()) return result;
  doubt_other_sizes(by_gain.channel);
  const bool named_acceleration = named != input_.end() && !named->reference;
  ChannelMatches by_delay = by_gain;
  // The loop-back may not have been given the signal.
  if (loops_back() && !named_acceleration && loop_back_was_fed(by_gain.channel)) {
    by_delay = match_channels(band, references);
    if (by_delay.channel.empty()) by_delay = by_gain;
  }
  if (named != input_.end() && by_gain.channel[static_cast<std::size_t>(named - input_.begin())].verdict !=
                                   ChannelMatch::Verdict::kMatched) {
    result.refusal = text_of(ChannelMatches::Reason::kReference);
    return result;
  }
  // A channel left as it is keeps the delay that it had; that one is not compared.
  const double stays_s = named == input_.end() ? 0.0 : named->present_delay_s;
  for (std::size_t i = 0; i < input_.size(); ++i) {
    Channel channel{input_[i].name, by_gain.channel[i]};
    channel.match.delay_s = by_delay.channel[i].delay_s;
    channel.match.delay_sigma_s = by_delay.channel[i].delay_sigma_s;
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

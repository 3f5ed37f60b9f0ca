#include "host/analysis/spectra/envelopes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace roadbalance {

EnvelopeMeter::EnvelopeMeter(const NodeConfig& node)
    : node_(node),
      scans_(std::max(1, static_cast<std::int32_t>(std::lround(kBucket_s * node.rate_hz)))),
      ring_(kMostBuckets + 1) {}

/// Buckets up to this one are there, empty if no scan came.
void EnvelopeMeter::open(std::int64_t number) {
  const auto size = static_cast<std::int64_t>(ring_.size());
  if (newest_ < 0) first_ = newest_ = number, bucket(number) = {};
  for (std::int64_t next = std::max(newest_ + 1, number - size + 1); next <= number; ++next)
    bucket(next) = {};
  newest_ = number;
  first_ = std::max(first_, number - size + 1);
}

void EnvelopeMeter::add(const ScanBlock& block) {
  if (block.header.epoch != epoch_ || block.header.first_scan < scan_) newest_ = -1;
  epoch_ = block.header.epoch;
  period_ps_ = block.period_ps;
  time_ns_ = block.header.time_ns;
  scan_ = block.header.first_scan;
  for (std::int64_t r = 0; r < block.header.scans; ++r) {
    const auto& row = block.counts[static_cast<std::size_t>(r)];
    const std::int64_t number = (scan_ + r) / scans_;
    if (number != newest_) open(number);
    Bucket& now = bucket(number);
    for (std::size_t c = 0; c < kAccelerations; ++c) {
      now.least[c] = now.scans == 0 ? row[c] : std::min(now.least[c], row[c]);
      now.greatest[c] = now.scans == 0 ? row[c] : std::max(now.greatest[c], row[c]);
    }
    ++now.scans;
  }
}

std::optional<Envelope> EnvelopeMeter::envelope(std::int32_t channel) const {
  if (newest_ < 0 || channel < 0 || channel >= static_cast<std::int32_t>(node_.channel.size()))
    return std::nullopt;
  const auto c = static_cast<std::size_t>(channel);
  const ChannelConfig& config = node_.channel[c];
  const auto at = [&](std::int64_t number) -> const Bucket& {
    return ring_[static_cast<std::size_t>(number % static_cast<std::int64_t>(ring_.size()))];
  };
  // One that is being filled is not sent before it is full.
  const std::int64_t end = newest_ + (at(newest_).scans == scans_ ? 1 : 0);
  const std::int64_t first = std::max(first_, end - static_cast<std::int64_t>(kMostBuckets));
  if (first >= end) return std::nullopt;
  Envelope envelope{.node = node_.id,
                    .channel = channel,
                    .epoch = epoch_,
                    .first = first,
                    .scans = scans_,
                    .time_ns = time_ns_ + (first * scans_ - scan_) * period_ps_ / 1000,
                    .period_ps = period_ps_};
  for (std::int64_t number = first; number < end; ++number) {
    const Bucket& bucket = at(number);
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    if (bucket.scans != scans_) {
      envelope.bucket.push_back({kNone, kNone});
      continue;
    }
    // A calibration may turn the direction.
    const auto [least, greatest] =
        std::minmax({config.to_si(bucket.least[c]), config.to_si(bucket.greatest[c])});
    envelope.bucket.push_back({static_cast<float>(least), static_cast<float>(greatest)});
  }
  return envelope;
}

}  // namespace roadbalance

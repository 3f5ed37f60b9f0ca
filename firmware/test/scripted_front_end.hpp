#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "common/frontend/front_end.hpp"

namespace roadbalance::test {

/// Value of channel `channel` of scan `index`, so that a scan in the wrong place shows.
inline std::int32_t marked_counts(std::int64_t index, std::size_t channel) {
  return static_cast<std::int32_t>((index * 16 + static_cast<std::int64_t>(channel)) % kFullScaleCounts);
}

/// Hands out prepared scans, edges and signals, as many at a time as set.
class ScriptedFrontEnd final : public FrontEnd {
 public:
  ScriptedFrontEnd(std::vector<Scan> scans, std::vector<Edge> edges, std::size_t run = 64)
      : scans_(std::move(scans)), edges_(std::move(edges)), run_(run) {}

  std::vector<SignalSample> signals{};         ///< in order of time
  std::vector<const DeviceReport*> devices{};  ///< behind it

  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> samples) noexcept override {
    Read read;
    while (read.scans < std::min(run_, scans.size()) && next_scan_ < scans_.size())
      scans[read.scans++] = scans_[next_scan_++];
    const bool end = next_scan_ == scans_.size();
    while (read.edges < edges.size() && next_edge_ < edges_.size() &&
           (end || edges_[next_edge_].time <= scans_[next_scan_ - 1].time))
      edges[read.edges++] = edges_[next_edge_++];
    while (read.signals < samples.size() && next_signal_ < signals.size() &&
           (end || signals[next_signal_].time <= scans_[next_scan_ - 1].time))
      samples[read.signals++] = signals[next_signal_++];
    if (end && next_edge_ == edges_.size() && next_signal_ == signals.size()) read.status = ReadStatus::kEnd;
    return read;
  }
  std::vector<const DeviceReport*> reports() const override { return devices; }
  bool waits() const noexcept override { return true; }

 private:
  std::vector<Scan> scans_;
  std::vector<Edge> edges_;
  std::size_t run_;
  std::size_t next_scan_ = 0, next_edge_ = 0, next_signal_ = 0;
};

/// Scans [from, to) at `rate_hz`, time 0 at index 0, marked.
inline std::vector<Scan> marked_scans(std::int64_t from, std::int64_t to, double rate_hz) {
  std::vector<Scan> scans;
  for (std::int64_t i = from; i < to; ++i) {
    Scan scan;
    scan.index = i;
    scan.time = node_time_from_ns(std::llround(static_cast<double>(i) * 1e9 / rate_hz));
    for (std::size_t c = 0; c < scan.counts.size(); ++c) scan.counts[c] = marked_counts(i, c);
    scans.push_back(scan);
  }
  return scans;
}

}  // namespace roadbalance::test

#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "common/frontend/front_end.hpp"

namespace roadbalance {

/// A front end that hands out scans and edges prepared in memory.
class CsvFrontEnd final : public FrontEnd {
 public:
  CsvFrontEnd(std::vector<Scan> scans, std::vector<Edge> edges)
      : scans_(std::move(scans)), edges_(std::move(edges)) {}

  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample>) noexcept override {
    Read read;
    read.scans = std::min(scans.size(), scans_.size() - next_scan_);
    std::copy_n(scans_.begin() + static_cast<std::ptrdiff_t>(next_scan_), read.scans, scans.begin());
    next_scan_ += read.scans;
    const bool last = next_scan_ == scans_.size();
    while (read.edges < edges.size() && next_edge_ < edges_.size() &&
           (last || edges_[next_edge_].time <= scans_[next_scan_ - 1].time))
      edges[read.edges++] = edges_[next_edge_++];
    if (last && next_edge_ == edges_.size()) read.status = ReadStatus::kEnd;
    return read;
  }
  bool waits() const noexcept override { return true; }

 private:
  std::vector<Scan> scans_;
  std::vector<Edge> edges_;
  std::size_t next_scan_ = 0, next_edge_ = 0;
};

}  // namespace roadbalance

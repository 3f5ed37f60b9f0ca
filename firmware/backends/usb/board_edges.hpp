#pragma once

#include <cstddef>
#include <vector>

#include "common/frontend/device_report.hpp"
#include "common/frontend/front_end.hpp"

namespace roadbalance {

/// Edges until their scans go; what does not fit is counted and told by a mark.  Never allocates after
/// construction.
class BoardEdges {
 public:
  explicit BoardEdges(DeviceReport& report) : report_(report) {}

  void add(const Edge& edge) noexcept {
    bool& lost = lost_[edge.line];
    if (size_ + 2 > kEdges) {
      if (!lost) report_.count(DeviceCounter::kEdgesLost);
      lost = true;
      return;
    }
    if (lost) push({edge.time, edge.line, EdgeKind::kLost});
    lost = false;
    push(edge);
  }
  const Edge* front() const noexcept { return size_ == 0 ? nullptr : &edge_[begin_ % kEdges]; }
  void drop() noexcept { ++begin_, --size_; }

 private:
  static constexpr std::size_t kEdges = 8192;
  void push(const Edge& edge) noexcept { edge_[(begin_ + size_++) % kEdges] = edge; }

  DeviceReport& report_;
  std::vector<Edge> edge_ = std::vector<Edge>(kEdges);
  std::size_t begin_ = 0, size_ = 0;
  std::array<bool, kEncoderLines> lost_{};
};

}  // namespace roadbalance

#pragma once

#include <memory>
#include <vector>

#include "common/frontend/dropped_edges.hpp"
#include "common/frontend/front_end.hpp"
#include "common/frontend/side_source.hpp"

namespace roadbalance {

/// The scans of one device and what others give beside them, on one time line by their stamps: those of side
/// sources are of the machine's clock and become node time by FrontEnd::node_time.
///
/// A scan waits until every side source has handed over what was stamped before it, at most 50 ms; an edge
/// that comes later still is counted (kLateEdges) and not used, for its scans have gone; the next one of its
/// line follows a mark of kLost.  The edges of all are merged in order of time.  Never allocates after
/// construction.
class MixedFrontEnd final : public FrontEnd {
 public:
  /// @param rate_hz  of scans, nominal
  /// @throws ConfigError if `scans` is a device that waits: its time does not go with the machine's
  MixedFrontEnd(std::unique_ptr<FrontEnd> scans, std::vector<std::unique_ptr<SideSource>> sides,
                double rate_hz);

  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept override;
  ScanStamps scan_stamps() const noexcept override { return scans_->scan_stamps(); }
  NodeTime node_time(MachineTime machine) const noexcept override { return scans_->node_time(machine); }
  NodeTime begins() const noexcept override { return scans_->begins(); }
  std::vector<const DeviceReport*> reports() const override;

 private:
  static constexpr std::size_t kEdgesWaiting = 16'384;
  static constexpr auto kLongestWait = std::chrono::milliseconds(50);

  NodeTime from_machine(NodeTime stamp) const noexcept;
  void fetch_scans(std::span<SignalSample> signals, Read& read) noexcept;
  NodeTime fetch_sides(std::span<SignalSample> signals, Read& read) noexcept;
  void keep_edges(std::span<const Edge> edges) noexcept;
  bool queue(const Edge& edge) noexcept;
  void hand_over(NodeTime until, std::span<Scan> scans, std::span<Edge> edges, Read& read) noexcept;

  const std::unique_ptr<FrontEnd> scans_;
  const std::vector<std::unique_ptr<SideSource>> sides_;
  DeviceReport report_{"node"};
  std::vector<Scan> scan_;  ///< fetched, in order; `scans_waiting_` of them count
  std::size_t scans_waiting_ = 0;
  std::vector<Edge> edge_;  ///< fetched, in order of time; `edges_waiting_` of them count
  std::size_t edges_waiting_ = 0;
  std::vector<Edge> fetched_;
  DroppedEdges dropped_;
  NodeTime newest_scan_ = NodeTime::min();
  NodeTime given_until_ = NodeTime::min();
  ReadStatus status_ = ReadStatus::kOk;
};

}  // namespace roadbalance

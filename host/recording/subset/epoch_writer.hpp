#pragma once

#include <functional>
#include <string>

#include "common/record/recorded_clocks.hpp"
#include "host/recording/subset/epoch_sink.hpp"

namespace roadbalance {

/// Writes one node epoch of a new recording: numbers its blocks from 1 and its scans from 0, begins with the
/// vehicle's description, and ends like a node.
class EpochWriter final : public EpochSink {
 public:
  using Put = std::function<void(const SealedBlock&)>;

  EpochWriter(NodeEpoch key, const std::string& vehicle_toml, Put put);

  void scans(const ScanBlock& block) override;
  void gap(std::int64_t scans, std::int64_t time_ns, GapCause cause) override;
  void edges(std::span<const Edge> edges) override;
  void signals(std::span<const SignalSample> samples) override;
  void end(Ending ending) override;

 private:
  template <typename Block>
  void write(Block& block, std::int64_t scans, std::int64_t time_ns);
  template <typename Block, typename Item>
  void write_all(std::span<const Item> items);

  const NodeEpoch key_;
  const Put put_;
  SealedBlock sealed_;
  BlockSum sum_;
  std::int64_t next_sequence_ = 1;
  std::int64_t next_scan_ = 0;
  std::int64_t end_ns_ = 0;  ///< node time behind the last scan or gap
  std::int64_t period_ps_ = 0;
  std::int64_t sealed_scans_ = 0, missing_scans_ = 0;
  bool after_gap_ = false;
};

}  // namespace roadbalance

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/types/block.hpp"
#include "common/types/exchange.hpp"
#include "host/analysis/identify/common_rows.hpp"

namespace roadbalance {

/// The scans of some nodes at common instants, row by row (CommonRows).  The rows of a single node without
/// delays are its scans unchanged.
class GridJoin {
 public:
  static constexpr double kLongestWait_s = 300.0;  ///< of drive; 40 MB a node at 2 kHz

  /// Values of a node's 16 channels at an instant.
  struct Sample {
    const std::array<float, kChannels>* counts;
    std::int32_t overload, quality;
  };
  struct Row {
    bool restart;                       ///< it does not go on from the row before
    const std::vector<Sample>& sample;  ///< [node], as they were given
  };
  using Emit = std::function<void(const Row&)>;

  /// @param nodes           each once
  /// @param longest_wait_s  for a node that is behind
  GridJoin(const std::vector<const NodeConfig*>& nodes, Emit emit, double longest_wait_s = kLongestWait_s);

  void consume(const SealedBlock& block);
  void consume(const ScanBlock& block);
  /// In the order of the record: a fit counts for the blocks of its node that come after it.
  void consume(const ClockFit& fit);

  /// Why a node's scans cannot be brought to the others'; empty: they can.
  std::string refusal() const { return rows_.refusal(); }

 private:
  void emit();
  void emit_rows(const CommonRows::Run& run);

  CommonRows rows_;
  std::vector<Sample> sample_;
  Emit emit_;
};

}  // namespace roadbalance

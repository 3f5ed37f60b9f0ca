#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/angle/reference_filter.hpp"
#include "common/config/vehicle_config.hpp"
#include "host/analysis/angle/edge_memory.hpp"
#include "host/analysis/angle/recorded_angle.hpp"

namespace roadbalance {

/// Channels 13 .. 16 of a node computed from its recorded edges, whatever the record has there: angle of each
/// wheel by RecordedAngle, through the digital copy of the filter.
///
/// A drive is read twice: learn() of all its blocks, then of() each scan block in sequence.
class ComputedReferences {
 public:
  /// @param memory  that its edges may take
  ComputedReferences(const VehicleConfig& vehicle, const NodeConfig& node, EdgeMemory memory = EdgeMemory());

  /// @throws std::runtime_error if there are more edges than the machine can hold
  void learn(const SealedBlock& block);

  struct Rows {
    std::array<std::array<std::int32_t, kChannels>, kScansPerBlock> counts{};  ///< 12 .. 15 are filled
    std::int32_t quality = 0;                                                  ///< quality_no_reference bits
  };
  const Rows& of(const ScanBlock& block);

 private:
  RecordedAngle* angle(std::int64_t epoch, std::size_t line);

  const std::int32_t node_;
  std::array<std::optional<EncoderConfig>, kEncoderLines> encoder_;  ///< nothing: none that gives edges
  ReferenceFilter filter_;
  EdgeMemory memory_;
  std::map<std::pair<std::int64_t, std::size_t>, std::vector<Edge>> edges_;  ///< by epoch and line
  std::map<std::pair<std::int64_t, std::size_t>, std::unique_ptr<RecordedAngle>> angles_;
  std::array<std::vector<double>, kEncoderLines> angle_rad_;
  std::int64_t epoch_ = 0, next_scan_ = -1;
  Rows rows_;
};

}  // namespace roadbalance

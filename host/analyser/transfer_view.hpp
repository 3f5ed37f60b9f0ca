#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <vector>

#include "common/bus/transfer_report.hpp"
#include "common/clock/clocks.hpp"
#include "common/clock/exchange.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/link/block.hpp"
#include "host/analyser/spectra_pool.hpp"

namespace roadbalance {

/// Transfer functions that somebody wants to see, and no others.
///
/// A viewer says again what it wants, and is forgotten after kForgotten.  Views of the same channels,
/// segments, window and average share one JointSpectra, begun anew when it is first asked for: a channel that
/// clips, or a node that is silent, keeps nobody from seeing others.
class TransferView {
 public:
  static constexpr std::chrono::seconds kForgotten{3};
  static constexpr std::size_t kMostSpectra = 8, kMostViewers = 32;
  static constexpr std::size_t kMostBytes = 48U << 20U;  ///< of one JointSpectra, about
  static constexpr std::size_t kMostShown = 576;         ///< bins; of more, neighbours are averaged

  explicit TransferView(const VehicleConfig& vehicle)
      : pool_(vehicle, {kMostSpectra, kMostBytes, kMostSpectra * kMostBytes}) {}

  void take(const View& view, WallTime now);
  void consume(const SealedBlock& block) { pool_.consume(block); }
  void consume(const ClockFit& fit) { pool_.consume(fit); }

  /// All parts of all pairs that have something new to tell; of those that cannot be told, once, why.
  std::vector<TransferPart> parts(WallTime now);

 private:
  using Kind = SpectraPool::Kind;
  struct Viewer {
    View view;
    Kind kind;
    WallTime heard;
    TransferState state = TransferState::kTold;
    int told = -1;  ///< averages, or minus what was told in place of them
  };
  Kind kind_of(const View& view) const;
  void forget(WallTime now);
  void add_pairs(const Viewer& viewer, TransferState state, const JointSpectra* spectra,
                 std::vector<TransferPart>& parts) const;

  SpectraPool pool_;
  std::map<std::int64_t, Viewer> viewers_;
};

}  // namespace roadbalance

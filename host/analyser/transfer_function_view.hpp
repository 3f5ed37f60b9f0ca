#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <vector>

#include "common/bus/transfer_function_report.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/block.hpp"
#include "common/types/clocks.hpp"
#include "common/types/exchange.hpp"
#include "host/analysis/spectra/spectra_pool.hpp"

namespace roadbalance {

/// Transfer functions that viewers ask for, and no others.
///
/// A viewer repeats its request, and is forgotten after kForgotten.  Views of the same channels,
/// segments, window and average share one JointSpectra, begun anew when it is first asked for: a channel that
/// clips, or a node that is silent, keeps no viewer from others.
class TransferFunctionView {
 public:
  static constexpr std::chrono::seconds kForgotten{3};
  static constexpr std::size_t kMostSpectra = 8, kMostViewers = 32;
  static constexpr std::size_t kMostBytes = 48U << 20U;  ///< of one JointSpectra, about
  static constexpr std::size_t kMostShown = 576;         ///< bins; of more, neighbours are averaged

  explicit TransferFunctionView(const VehicleConfig& vehicle)
      : pool_(vehicle, {kMostSpectra, kMostBytes, kMostSpectra * kMostBytes}) {}

  void take(const View& view, WallTime now);
  void consume(const SealedBlock& block) { pool_.consume(block); }
  void consume(const ClockFit& fit) { pool_.consume(fit); }

  /// All parts of all pairs that have something new; of those that cannot be computed, once, why.
  std::vector<TransferFunctionPart> parts(WallTime now);

 private:
  using Kind = SpectraPool::Kind;
  struct Viewer {
    View view;
    Kind kind;
    WallTime heard;
    SpectralState state = SpectralState::kComputed;
    int sent = -1;  ///< averages, or minus the state sent in place of them
  };
  Kind kind_of(const View& view) const;
  void forget(WallTime now);
  void add_pairs(const Viewer& viewer, SpectralState state, const JointSpectra* spectra,
                 std::vector<TransferFunctionPart>& parts) const;

  SpectraPool pool_;
  std::map<std::int64_t, Viewer> viewers_;
};

}  // namespace roadbalance

#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/bus/results.hpp"
#include "common/types/clocks.hpp"
#include "host/analysis/spectra/spectra_pool.hpp"

namespace roadbalance {

/// Spectra of single channels that viewers ask for, and no others.
///
/// As TransferFunctionView; each channel is averaged by itself, so that one that clips costs no other.
class SpectrumView {
 public:
  static constexpr std::chrono::seconds kForgotten{3};
  static constexpr std::size_t kMostSpectra = 64, kMostViewers = 32;
  static constexpr std::size_t kMostBytes = 16U << 20U, kMostBytesAll = 96U << 20U;
  static constexpr std::size_t kMostShown = 1200;  ///< bins; of more, neighbours are averaged

  explicit SpectrumView(const VehicleConfig& vehicle)
      : pool_(vehicle, {kMostSpectra, kMostBytes, kMostBytesAll}) {}

  void take(const View& view, WallTime now);
  void consume(const SealedBlock& block) { pool_.consume(block); }
  void consume(const ClockFit& fit) { pool_.consume(fit); }

  /// All parts of all spectra that have something new.  A spectrum that cannot be computed (yet) gives one
  /// part without bins, whenever the reason changes.
  std::vector<SpectrumPart> parts(WallTime now);

 private:
  using Kind = SpectraPool::Kind;
  struct Wanted {
    ChannelId channel;
    Kind kind;
    SpectralState state = SpectralState::kComputed;       ///< of what was begun
    std::optional<std::pair<SpectralState, int>> sent{};  ///< with how many averages
  };
  struct Viewer {
    double highest_hz = 0.0;
    WallTime heard;
    std::vector<Wanted> wanted;
  };
  void forget(WallTime now);

  SpectraPool pool_;
  std::map<std::int64_t, Viewer> viewers_;
};

}  // namespace roadbalance

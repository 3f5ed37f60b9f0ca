#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "common/bus/transfer_report.hpp"
#include "common/clock/clocks.hpp"
#include "common/clock/exchange.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/link/block.hpp"
#include "host/analyser/joint_spectra.hpp"

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

  explicit TransferView(const VehicleConfig& vehicle);

  void take(const View& view, WallTime now);
  void consume(const SealedBlock& block);
  /// A fit is kept for spectra that somebody will ask for later.
  void consume(const ClockFit& fit);

  /// All parts of all pairs that have something new to tell; of those that cannot be told, once, why.
  std::vector<TransferPart> parts(WallTime now);

 private:
  /// What spectra are made of.
  using Kind = std::tuple<std::vector<ChannelId>, int, Window, int, double>;
  struct Viewer {
    View view;
    Kind kind;
    WallTime heard;
    TransferState state = TransferState::kTold;
    int told = -1;  ///< averages, or minus what was told in place of them
  };
  Kind kind_of(const View& view) const;
  TransferState begin(const Kind& kind);
  void forget(WallTime now);
  void add_pairs(const Viewer& viewer, TransferState state, const JointSpectra* spectra,
                 std::vector<TransferPart>& parts) const;

  VehicleConfig vehicle_;
  std::map<ChannelId, ChannelPlace> place_;  ///< of channels in use
  std::map<Kind, std::unique_ptr<JointSpectra>> spectra_;
  std::map<std::int64_t, Viewer> viewers_;
  std::map<std::int32_t, ClockFit> newest_fit_;  ///< by node
};

}  // namespace roadbalance

#pragma once

#include <array>
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
/// A viewer says again what it wants, and is forgotten after kForgotten.  Views of the same segments, window
/// and average share one JointSpectra of all channels whose nodes sample at one rate; there are at most
/// kMostKinds of those, since each costs memory for all pairs.  One is begun anew when it is first asked for.
class TransferView {
 public:
  static constexpr std::chrono::seconds kForgotten{3};
  static constexpr std::size_t kMostKinds = 4, kMostViewers = 32;
  static constexpr std::size_t kMostShown = 576;  ///< bins; of more, neighbours are averaged

  explicit TransferView(const VehicleConfig& vehicle);

  /// Pairs of channels that there are not, or of nodes of different rates, are left out.
  void take(const View& view, WallTime now);
  void consume(const SealedBlock& block);
  void consume(const ClockFit& fit);

  /// All parts of all pairs that are wanted and have something new to tell.
  std::vector<TransferPart> parts(WallTime now);

 private:
  using Kind = std::tuple<int, Window, int, double>;  ///< segment, window, memory, overlap
  struct Spectra {
    std::vector<std::unique_ptr<JointSpectra>> of_rate;  ///< as rate_
  };
  struct Viewer {
    View view;
    WallTime heard;
    std::map<std::size_t, int> told;  ///< averages that were told, by rate
  };
  struct Place {
    std::size_t rate;
    int channel;  ///< index of JointSpectra
  };
  void forget(WallTime now);
  const Place* place_of(const ChannelId& id) const;
  void add_pair(const Viewer& viewer, const ChannelPair& pair, const CrossSpectra& spectra, int input,
                int output, std::vector<TransferPart>& parts) const;

  VehicleConfig vehicle_;
  std::vector<std::vector<ChannelPlace>> rate_;  ///< channels of nodes that sample alike
  std::map<ChannelId, Place> place_;
  std::map<Kind, Spectra> kinds_;
  std::map<std::int64_t, Viewer> viewers_;
  std::int64_t newest_ns_ = 0;
};

}  // namespace roadbalance

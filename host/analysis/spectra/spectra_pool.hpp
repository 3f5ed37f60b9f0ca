#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "common/bus/transfer_function_report.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/block.hpp"
#include "common/types/exchange.hpp"
#include "host/analysis/spectra/joint_spectra.hpp"

namespace roadbalance {

/// Cross spectra that viewers ask for, each kind once, begun when it is first asked for.
class SpectraPool {
 public:
  /// Channels and settings of spectra; two viewers who want the same share them.
  struct Kind {
    std::vector<ChannelId> channel;  ///< each once, in order
    int segment;
    Window window;
    int memory;
    bool hold_peaks;
    double overlap;
    friend auto operator<=>(const Kind&, const Kind&) = default;
  };
  struct Limits {
    std::size_t most;            ///< kinds at a time
    std::size_t most_bytes;      ///< of one kind, about
    std::size_t most_bytes_all;  ///< of all together, about
  };

  SpectraPool(const VehicleConfig& vehicle, const Limits& limits);

  /// Such a channel is there and in use.
  bool has(const ChannelId& channel) const { return place_.contains(channel); }
  /// kComputed: there is one from now on.
  SpectralState begin(const Kind& kind);
  /// nullptr if it was not begun.
  const JointSpectra* find(const Kind& kind) const;
  void keep_only(const std::function<bool(const Kind&)>& wanted);

  void consume(const SealedBlock& block);
  /// A fit is kept for spectra that a viewer may ask for later.
  void consume(const ClockFit& fit);

 private:
  static std::size_t bytes(const Kind& kind);

  VehicleConfig vehicle_;
  Limits limits_;
  std::map<ChannelId, ChannelPlace> place_;  ///< of channels in use
  std::map<Kind, std::unique_ptr<JointSpectra>> spectra_;
  std::map<std::int32_t, ClockFit> newest_fit_;  ///< by node
};

/// State of such spectra; kComputed if anything was averaged.
SpectralState state_of(const JointSpectra& spectra);

}  // namespace roadbalance

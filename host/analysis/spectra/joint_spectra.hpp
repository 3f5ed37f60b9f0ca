#pragma once

#include <cstdint>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/cross_spectra.hpp"
#include "common/types/block.hpp"
#include "common/types/exchange.hpp"
#include "host/analysis/identify/common_rows.hpp"

namespace roadbalance {

/// A channel of a vehicle, as indices.
struct ChannelPlace {
  int node;     ///< into VehicleConfig::node
  int channel;  ///< into NodeConfig::channel
};

/// Sealed blocks in, cross spectra of some channels out, in the units of the channels (m/s^2), whichever
/// nodes they are of: their samples are brought to one grid of time first.
///
/// Rows in which a channel left its range, and rows that a node lacks, are holes: no segment runs across one.
class JointSpectra {
 public:
  struct Settings {
    int segment;           ///< samples, >= 2
    double overlap = 0.5;  ///< 0 <= overlap < 1
    Window window = Window::kHann;
    int memory = 0;           ///< as CrossSpectra::Settings
    bool hold_peaks = false;  ///< the same
  };

  /// @param channels  one or more; a channel's index in spectra() is its place here
  /// @throws std::invalid_argument
  JointSpectra(const VehicleConfig& vehicle, std::vector<ChannelPlace> channels, const Settings& settings);

  void consume(const SealedBlock& block);
  /// How a node's clock stands to the host's, for the blocks of that node that come next.
  void consume(const ClockFit& fit);

  const CrossSpectra& spectra() const { return spectra_; }
  /// Time of the newest sample taken, ns: the host's, but of one node alone that node's.
  std::int64_t end_ns() const { return end_ns_; }
  /// Runs of samples without a hole so far.
  int runs() const { return runs_; }
  /// Why a node's samples cannot be brought to the grid of the others; empty: all can.
  std::string refusal() const { return rows_.refusal(); }

 private:
  struct Source {
    std::size_t stream;
    std::size_t channel;
    double scale, offset;  ///< from counts
  };
  void take_runs();

  CommonRows rows_;
  CrossSpectra spectra_;
  std::vector<Source> sources_;
  Eigen::MatrixXd samples_;
  std::int64_t end_ns_ = 0;
  int runs_ = 0;
};

}  // namespace roadbalance

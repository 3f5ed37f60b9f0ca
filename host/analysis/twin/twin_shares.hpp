#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/cross_spectra.hpp"
#include "common/dsp/state_filter.hpp"
#include "host/analysis/twin/twin.hpp"

namespace roadbalance {

/// Root mean squares of a channel, m/s^2.
struct TwinFigures {
  double measured = 0.0, predicted = 0.0, residual = 0.0;

  /// How much of the measured mean square the prediction explains: 1 all, 0 nothing, less than 0: no
  /// prediction would have been better.  NaN of a channel that measured nothing.
  double share() const;
};

/// Result of the twin for one channel over some time.
struct TwinAccount {
  TwinState state = TwinState::kSettling;  ///< not kComputed: nothing of what follows holds
  TwinFigures all, hop;                    ///< the whole band; kHopLow_hz .. kHopHigh_hz
  /// The share that would be explained if the prediction's gain and phase were right at each frequency: mean
  /// of the coherence of measured and predicted, weighed by the measured density.  The part missing to 1 has
  /// other causes than the prediction's: noise, or another road than the other axle's.  By chance it is
  /// greater than 0 by 1 / averages.  NaN: no spectrum yet.
  double coherent_all = 0.0, coherent_hop = 0.0;
};

inline constexpr double kHopLow_hz = 10.0, kHopHigh_hz = 25.0;
inline constexpr int kTracePoints = 125;  ///< of a second

/// One second of all channels.
struct TwinSecond {
  std::int64_t time_ns = 0;  ///< of its last sample
  double speed_m_s = 0.0;    ///< mean; 0: not known
  struct Channel {
    TwinAccount account;
    /// Means of neighbouring samples, for the eye, m/s^2.
    std::array<float, kTracePoints> measured{}, predicted{};
  };
  std::vector<Channel> channel;  ///< as in TwinChannels
};

/// Mean squares of measured, predicted and residual, second by second and altogether.
///
/// A second counts for a channel only if all of it is predicted.  The band is cut out by a band-pass of
/// fourth order, measured and predicted alike.
class TwinShares {
 public:
  /// @param memory  seconds of drive whose spectra are remembered; 0: all
  TwinShares(const TwinChannels& channels, double rate_hz, double memory_s);

  /// @return the second that this sample completes, valid until the next call; else nothing
  const TwinSecond* add(const TwinSample& sample);

  /// [channels] altogether; state kComputed if there is at least one second of it, else why there was none
  /// last.
  std::vector<TwinAccount> total() const;
  /// [channels] so many seconds of each are in it.
  const std::vector<int>& seconds() const { return seconds_; }

 private:
  /// [channel] of squares: measured, predicted, residual; the same of the band.
  using Squares = Eigen::Array<double, Eigen::Dynamic, 6>;
  static Squares squares_of(Eigen::Index channels) { return Squares::Zero(channels, 6); }

  void begin_second();
  void add_squares(const TwinSample& sample);
  void add_trace(const TwinSample& sample);
  void end_second();
  void put_coherent(std::vector<TwinAccount*>& accounts) const;

  TwinChannels channels_;
  int samples_;  ///< of a second
  double step_ns_;
  StateFilter band_;
  double band_gain_;
  CrossSpectra spectra_;
  Eigen::MatrixXd spectra_in_;  ///< [2 channels x samples of a second]
  Eigen::ArrayXd both_;         ///< measured, then predicted of all channels
  Squares now_, all_;
  std::vector<int> seconds_;
  std::vector<TwinState> state_;  ///< [channels] of this second
  int filled_ = 0;
  std::int64_t last_ns_ = 0;
  double speed_sum_ = 0.0;
  TwinSecond second_;
};

}  // namespace roadbalance

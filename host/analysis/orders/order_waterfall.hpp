#pragma once

#include <complex>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/dsp/fft.hpp"
#include "common/dsp/window.hpp"
#include "host/analysis/orders/turn_blocks.hpp"

namespace roadbalance {

/// Amplitudes at the orders 0, step, 2 step ..., in the unit of the channel.
struct OrderSpectrum {
  double step = 0.0;  ///< between lines, orders
  double noise_bandwidth =
      0.0;  ///< of a line, orders: noise of density S per order shows sqrt(2 S bandwidth)
  std::vector<double> amplitude;  ///< peak, not rms; nothing: no block came
  std::vector<int> averages;      ///< blocks a line was averaged over; falls where fast blocks end
};

/// Order spectra of some channels by classes of the wheel's speed.
///
/// A block is windowed (flat top: the height of a line is right within 0.05 % wherever it falls) and
/// transformed; squares are averaged:
///
///     amplitude[k] = 2 / sum(w) sqrt(mean over blocks of |DFT(w x)[k]|^2),   1 / sum(w) for order 0
///
/// so a component A cos(h alpha + phi) shows A at order h, and one whose amplitude changes its rms over the
/// blocks.  A line is as wide as the window: 3.8 steps, and it stands free of another from 10 steps on. Lines
/// above highest_hz at the class's fastest are left out.
///
/// Memory: channels x lines doubles for each class that occurred, at most kMostClasses.
class OrderWaterfall {
 public:
  static constexpr int kMostClasses = 100;

  struct Settings {
    int channels;
    int rows_per_turn;
    int turns;             ///< of a block; lines lie 1 / turns apart
    double highest_order;  ///< that the rows hold
    double highest_hz;     ///< that the samples hold
    double class_hz;       ///< width of a speed class, turns a second
  };
  struct Row {
    double from_hz, to_hz;  ///< turns a second
    OrderSpectrum spectrum;
  };

  /// @throws std::invalid_argument
  explicit OrderWaterfall(const Settings& settings);

  void add(const TurnBlock& block);

  /// [class that occurred] of one channel, ascending.
  std::vector<Row> rows(int channel) const;
  /// Over all speeds; each line over the blocks that hold it.
  OrderSpectrum spectrum(int channel) const;

  /// Blocks faster than all classes.
  std::int64_t too_fast() const { return too_fast_; }

 private:
  struct Sums {
    std::vector<int> blocks;  ///< [channel]
    Eigen::MatrixXd squares;  ///< [line x channel] of amplitudes
  };
  Eigen::Index lines_of(int speed_class) const;
  OrderSpectrum empty() const;

  Settings settings_;
  RealFft fft_;
  std::vector<double> window_;
  double scale_;
  Eigen::Index lines_;  ///< up to the highest order
  std::vector<double> tapered_;
  std::vector<std::complex<double>> transform_;
  std::map<int, Sums> classes_;
  std::int64_t too_fast_ = 0;
};

}  // namespace roadbalance

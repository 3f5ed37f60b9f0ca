#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "host/analysis/orders/mean_vector.hpp"
#include "host/analysis/orders/turn_blocks.hpp"

namespace roadbalance {

/// True if an order has so many periods in what the angle is known modulo that its phase lasts.
inline bool is_whole(double periods) {
  return std::abs(periods - std::round(periods)) < 1e-9;
}

/// Amplitude and phase of orders against the reference point: x(alpha) = Re{X e^{j h alpha}}
/// (conventions.md).
///
/// In each block the channel is fitted by a constant and all wanted orders together, by least squares over
/// whole turns; blocks are averaged, over the whole drive and by class of speed, with the confidence that
/// their scatter allows (MeanVector).  Each vector is divided by what the recording did to it: with the
/// filter's response H, its phase phi and the angle that has passed the same filter, order h at f turns a
/// second is recorded as X H(h f) e^{-j h phi(f)}.
///
/// An order of which a whole number of periods does not go into what the angle is known modulo - of a wheel
/// with a zero mark, an order that is no whole number - has a phase only within an uninterrupted run, counted
/// from the run's own first turn: of such an order the longest run counts.  A block whose order lies above
/// highest_hz is left out.
class OrderVectors {
 public:
  static constexpr int kMostClasses = 100;

  struct Settings {
    int channels;
    int rows_per_turn;
    int turns;                  ///< of a block
    std::vector<double> order;  ///< at least 1 / turns, and that far apart
    double highest_hz;          ///< that the samples hold
    double class_hz;            ///< width of a speed class, turns a second
    /// The recorded vector of an order that is a unit vector, at so many turns a second; empty: unchanged.
    std::function<std::complex<double>(double order, double rotation_hz)> as_recorded;
    double known_share = 1.0;  ///< of a turn, that the angle is known modulo; 0: of what it is counted from
  };
  struct Class {
    double from_hz, to_hz;  ///< turns a second
    MeanVector vector;
  };
  struct Result {
    MeanVector all;
    std::vector<Class> by_speed;  ///< classes that occurred, ascending
  };

  /// @throws std::invalid_argument
  explicit OrderVectors(const Settings& settings);

  void add(const TurnBlock& block);

  /// @param order  place in Settings::order
  Result result(int channel, std::size_t order) const;

  /// Whether its phase is the same in all runs, and in another drive.
  bool has_phase(std::size_t order) const;

 private:
  struct Sums {
    MeanVector all;
    std::map<int, MeanVector> by_speed;
    std::int64_t run = 0;
  };
  /// Sums of one channel and order.
  struct Accumulator {
    Sums current;
    Sums best;  ///< the longest run so far, of an order that is no whole number
  };
  void add(const TurnBlock& block, std::size_t order, std::complex<double> vector, Accumulator& to) const;

  Settings settings_;
  Eigen::MatrixXd fit_;                   ///< [2 order + re, im x row]
  std::vector<Accumulator> accumulator_;  ///< [channel x order]
};

}  // namespace roadbalance

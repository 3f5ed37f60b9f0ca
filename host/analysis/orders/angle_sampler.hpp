#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/fractional_delay.hpp"

namespace roadbalance {

/// Values of all channels at one place of the wheel: at the angle 2 pi index / rows per turn.
struct AngleRow {
  std::int64_t index = 0;      ///< multiples of the rows per turn lie at angle 0 (conventions.md)
  bool restart = false;        ///< does not go on from the row before
  double time_s = 0.0;         ///< at the sampling rate, from the first sample given
  std::uint32_t overload = 0;  ///< bit k: channel k left its range in a sample this is made of
  Eigen::VectorXd values;      ///< [channel]
};

/// Samples at constant steps of time -> rows at constant steps of the wheel's angle.
///
/// The instant at which the wheel stands at a row's angle is found on the cubic through the four angles
/// around it (its error is (3/128) T^4 angle'''': 1e-7 rad for 1 degree of torsion at 13 Hz and 600 Hz);
/// there the channels are interpolated with FractionalDelay, which is a pure delay up to 0.38 of the sampling
/// rate to 3e-5.  So that nothing folds, rows must come at least as often as samples: rows_per_turn
/// least_rotation_hz >= rate_hz.
///
/// No row is made where the angle is not known, samples are missing, or the wheel turns slower than
/// least_rotation_hz or backwards in the 32 samples around: the next row is a restart.
class AngleSampler {
 public:
  static constexpr double kFastest = 0.25;  ///< turns a sample; faster, turns could not be counted

  struct Settings {
    int channels;
    double rate_hz;
    int rows_per_turn;
    double least_rotation_hz;
  };
  using Emit = std::function<void(const AngleRow&)>;

  /// @throws std::invalid_argument
  AngleSampler(const Settings& settings, Emit emit);

  /// The next sample.
  /// @param angle_rad  of the wheel, modulo a turn; nothing: not known
  /// @param values     [channel]
  /// @param overload   bit k: channel k left its range
  void add(std::optional<double> angle_rad, const Eigen::Ref<const Eigen::VectorXd>& values,
           std::uint32_t overload = 0);

  /// Samples are missing before the next one.
  void interrupt() { filled_ = 0; }

  /// Samples of known angle at which the wheel turned too slowly, or backwards.
  std::int64_t slow_samples() const { return slow_samples_; }

 private:
  static constexpr Eigen::Index kCapacity = 256;
  struct Sample {
    double angle_rad;  ///< unwrapped; the first of a run lies in 0 .. 2 pi
    std::uint32_t overload;
  };

  void push(double angle_rad, const Eigen::Ref<const Eigen::VectorXd>& values, std::uint32_t overload);
  void emit_complete();
  bool turns_here() const;
  /// From sample at_ to the next: the cubic of Lagrange through the angles of the four samples around.
  struct Step {
    double from_rad, turned_rad;
    double c1, c2, c3;  ///< angle = from_rad + c1 x + c2 x^2 + c3 x^3, x the part of the step

    /// Where the wheel stands at `angle_rad`.
    double part(double angle_rad) const;
  };
  Step step_here() const;
  void emit_row(double part);
  const Sample& sample(Eigen::Index i) const { return sample_[static_cast<std::size_t>(i)]; }

  Settings settings_;
  double step_rad_;
  FractionalDelay delay_;
  Eigen::MatrixXd values_;  ///< [channel x sample], column filled_ - 1 the newest
  std::vector<Sample> sample_;
  Eigen::Index filled_ = 0;
  Eigen::Index at_ = 0;    ///< sample at or before the next row
  std::int64_t came_ = 0;  ///< samples, of any kind
  std::int64_t slow_samples_ = 0;
  bool restart_ = true;
  AngleRow row_;
  Emit emit_;
};

}  // namespace roadbalance

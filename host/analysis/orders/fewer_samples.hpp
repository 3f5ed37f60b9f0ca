#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/decimating_filter.hpp"

namespace roadbalance {

/// Samples beside the angles of some wheels -> every factor-th of them, low-passed by decimation_taps: what
/// an order analysis of low frequencies needs.
///
/// A sample that is given has the angles of its own instant; it comes 8 factor samples late.  The first 16
/// factor after an interruption give none.  Where an angle is not known, or was lost since the sample given
/// before, one without it is given.
class FewerSamples {
 public:
  using Angle = std::optional<double>;
  /// @param angle_rad  [wheel]
  /// @param values     [channel]
  using Emit = std::function<void(std::span<const Angle> angle_rad,
                                  const Eigen::Ref<const Eigen::VectorXd>& values, std::uint32_t overload)>;

  /// @param factor  >= 1; 1 passes all
  FewerSamples(int channels, int factor, Emit emit);

  /// @param angles  wheels; 1 at first.  Only between interrupt() and the next sample.
  void follow(std::size_t angles);

  /// The angles of the next sample may be given.  For other samples it is enough to call lose_angle() if one
  /// is lost.
  bool wants_angle() const { return count_ == 0; }
  /// Angle of the next sample; without this call it is not known.
  void set_angle(std::size_t wheel, double angle_rad) { next_[wheel] = angle_rad; }
  /// That of the next sample is not known: nor is that of the one given next.
  void lose_angle(std::size_t wheel) { lost_[wheel] = 1; }
  /// @param values    [channel]
  /// @param overload  bit k: channel k left its range; given for all samples that one touches
  void add(const Eigen::Ref<const Eigen::VectorXd>& values, std::uint32_t overload);
  void interrupt();

 private:
  void remember_angles();
  void forget_angles();
  /// Overloads of the samples that the latest given one is made of.
  std::uint32_t overloads() const;

  int factor_;
  std::int64_t taps_;
  DecimatingFilter low_pass_;
  std::int64_t samples_ = 0;               ///< since an interruption
  std::array<std::int64_t, 32> overload_;  ///< [channel] its latest sample that left its range, from 1 on
  int count_ = 0;                          ///< samples_ modulo the factor
  std::vector<Angle> next_;                ///< [wheel]
  std::vector<std::uint8_t> lost_;         ///< [wheel] since the last sample that may be given
  std::vector<Angle> waiting_;             ///< [sample that may be given][wheel], of the latest
  Emit emit_;
};

}  // namespace roadbalance

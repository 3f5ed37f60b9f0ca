#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

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

  /// The angles of the next sample may be given.  Of others it is enough to say lose_angle() if one is lost.
  bool wants_angle() const { return count_ == 0; }
  /// Of the next sample; without it, it is not known.
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

  int factor_;
  Eigen::VectorXd taps_, sum_;
  Eigen::MatrixXd history_;              ///< [channel x sample], column filled_ - 1 the newest
  std::vector<std::uint32_t> overload_;  ///< of the samples in history_
  Eigen::Index filled_ = 0;
  Eigen::Index overloads_end_ = 0;  ///< of those in history_, behind the last that is not 0
  int count_ = 0;                   ///< samples since an interruption, modulo the factor
  std::vector<Angle> next_;         ///< [wheel]
  std::vector<std::uint8_t> lost_;  ///< [wheel] since the last sample that may be given
  std::vector<Angle> waiting_;      ///< [sample that may be given][wheel], of the latest
  Emit emit_;
};

}  // namespace roadbalance

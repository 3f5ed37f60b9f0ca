#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace roadbalance {

/// Samples beside a wheel's angle -> every factor-th of them, low-passed by decimation_taps: what an order
/// analysis of low frequencies needs.
///
/// A sample that is given has the angle of its own instant; it comes 8 factor samples late.  The first 16
/// factor after an interruption give none.  Where the angle is not known, or was lost since the one given
/// before, a sample without it is given.
class FewerSamples {
 public:
  using Emit = std::function<void(const std::optional<double>& angle_rad,
                                  const Eigen::Ref<const Eigen::VectorXd>& values, std::uint32_t overload)>;

  /// @param factor  >= 1; 1 passes all
  FewerSamples(int channels, int factor, Emit emit);

  /// The angle of the next sample may be given.  Of others it is enough to say lose_angle() if it is lost.
  bool wants_angle() const { return count_ == 0; }
  /// The angle of the next sample is not known: nor is that of the one given next.
  void lose_angle() { lost_ = true; }
  /// @param values    [channel]
  /// @param overload  bit k: channel k left its range; given for all samples that one touches
  void add(const std::optional<double>& angle_rad, const Eigen::Ref<const Eigen::VectorXd>& values,
           std::uint32_t overload);
  void interrupt() {
    filled_ = count_ = 0;
    lost_ = false;
  }

 private:
  struct Beside {
    std::optional<double> angle_rad;
    std::uint32_t overload;
    bool lost;  ///< here or in one of the factor - 1 samples before, which are not given
  };

  int factor_;
  Eigen::VectorXd taps_, sum_;
  Eigen::MatrixXd history_;     ///< [channel x sample], column filled_ - 1 the newest
  std::vector<Beside> beside_;  ///< the samples in history_
  Eigen::Index filled_ = 0;
  int count_ = 0;      ///< samples since an interruption, modulo the factor
  bool lost_ = false;  ///< the angle, since the last sample that may be given
  Emit emit_;
};

}  // namespace roadbalance

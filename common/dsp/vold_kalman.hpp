#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace roadbalance {

/// Amplitude and phase of several orders together, also while they cross: the Vold-Kalman filter of the
/// second generation with two poles, computed over a whole stretch at once.
///
/// Each channel is y(n) = sum_k Re{X_k(n) e^{j theta_k(n)}} + rest, and each envelope X_k changes slowly:
///
///     min  sum_n (y - sum_k Re{X_k e^{j theta_k}})^2 + (r^2 / 2) sum_k sum_n |X_k(n-1) - 2 X_k(n) +
///     X_k(n+1)|^2.
///
/// With one order alone, a component that lies off it by f is passed with H, half the power at half the
/// bandwidth B:
///
///     H(f) = 1 / (1 + r^2 (2 sin(pi f / rate))^4),    r^2 = (sqrt 2 - 1) / (2 sin(pi B / (2 rate)))^4.
///
/// Orders that cross are separated by their phases before and behind, if they are as near as B for no longer
/// than about 1 / B; orders that stay together are not: each then gets some of the other.  The normal
/// equations are real, symmetric, positive definite and of half band width 4 k; they are factorised once for
/// all channels (Eigen, LDL^T without reordering).
///
/// Sources: H. Vold, M. Mains, J. Blough, Theoretical foundations for high performance order tracking with
/// the Vold-Kalman tracking filter, SAE 972007 (1997); J. Tuma, Setting the passband width in the Vold-Kalman
/// order tracking filter, ICSV12, Lisbon 2005.
struct VoldKalman {
  double rate_hz;
  double bandwidth_hz;  ///< B, of half power, both sides together

  /// r^2.
  /// @throws std::invalid_argument unless kLeastShare rate <= B <= rate / 2: below, no digit would be left
  double weight() const;
  /// H.
  double passes(double off_hz) const;
  /// So far from an end the envelope is that of an endless record to 1e-6, of orders that cross there to a
  /// tenth of what the noise scatters them by: 6 / B.
  Eigen::Index reach() const;

  /// @param samples    [sample x channel]
  /// @param phase_rad  [sample x order] theta
  /// @return for each channel [sample x order] X
  /// @throws std::invalid_argument if the rows differ or are fewer than three; as weight()
  std::vector<Eigen::MatrixXcd> track(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& phase_rad) const;

  static constexpr double kLeastShare = 1e-3;
};

/// The same over an endless drive in constant memory: blocks that overlap by twice the filter's reach.
class VoldKalmanBlocks {
 public:
  /// A part of an uninterrupted run, in order.
  struct Block {
    const Eigen::MatrixXd& phase_rad;               ///< [sample x order], all that was tracked together
    const std::vector<Eigen::MatrixXcd>& envelope;  ///< [channel][sample x order], of all of it
    Eigen::Index first, count;                      ///< samples that are new, the others are surroundings
    Eigen::Index at;                                ///< of row 0 in the run
  };
  using Emit = std::function<void(const Block&)>;

  /// @throws std::invalid_argument
  VoldKalmanBlocks(const VoldKalman& filter, int channels, int orders, Emit emit);

  /// The next sample: [channel], [order].
  void add(const Eigen::Ref<const Eigen::VectorXd>& values,
           const Eigen::Ref<const Eigen::VectorXd>& phase_rad);
  /// The run ends here; one shorter than twice the reach gives nothing.
  void end_run();

 private:
  void track(Eigen::Index upto);

  VoldKalman filter_;
  Eigen::Index reach_;
  Eigen::MatrixXd values_, phase_rad_;  ///< [channel or order x sample]
  Eigen::Index filled_ = 0;
  Eigen::Index reported_ = 0;  ///< columns that were emitted
  Eigen::Index at_ = 0;        ///< of column 0 in the run
  Emit emit_;
};

}  // namespace roadbalance

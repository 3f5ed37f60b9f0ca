#pragma once

#include <array>
#include <complex>
#include <optional>

#include <Eigen/Core>

namespace roadbalance {

/// Where the true vector lies with 95 %: d' C^-1 d <= limit about the mean, an ellipse.
///
/// Hotelling's T^2 of n vectors: limit = 2 (n - 1) / (n - 2) F(0.95; 2, n - 2), and of F with two degrees in
/// its numerator the quantile is (m / 2) (0.05^(-2 / m) - 1), m = n - 2.  Source: T. W. Anderson, An
/// Introduction to Multivariate Statistical Analysis, Wiley 2003, 5.3.
struct Confidence {
  Eigen::Matrix2d covariance;  ///< C of the mean's (real, imaginary) part
  double limit;
  double amplitude;                 ///< the ellipse's extent along the mean vector
  std::optional<double> phase_rad;  ///< its extent across, as an angle; nothing: it holds the zero vector
};

/// Mean of a sequence of vectors with the confidence that their scatter allows, in constant memory.
///
/// Successive vectors may depend on each other - a road, or another wheel that turns almost in step, goes on
/// for longer than a block - and then the scatter of single ones is too small a measure.  So vectors are
/// also averaged in batches of 2, 4, 8 ... and of all lengths of which there are at least kLeastBatches, the
/// one whose batches claim the largest variance of the mean counts.  Changes slower than a twelfth of the
/// drive are not seen.
///
/// Source: batch means as in J. Banks et al., Discrete-Event System Simulation, Prentice Hall 2010, 11.5.
class MeanVector {
 public:
  static constexpr int kLeastVectors = 6;   ///< for any confidence
  static constexpr int kLeastBatches = 12;  ///< of more than one vector

  void add(std::complex<double> value);

  int count() const { return level_[0].count; }
  std::complex<double> mean() const { return {level_[0].mean(0), level_[0].mean(1)}; }
  /// Nothing if there are fewer than kLeastVectors.
  std::optional<Confidence> confidence() const;

 private:
  /// Means of 2^k vectors; Welford's recursion.
  struct Level {
    int count = 0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();  ///< sum of (x - mean)(x - mean)'
    std::optional<Eigen::Vector2d> unpaired;
  };
  std::array<Level, 20> level_;
};

}  // namespace roadbalance

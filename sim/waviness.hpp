#pragma once

#include <array>

#include <Eigen/Core>

namespace roadbalance::sim {

inline constexpr double kReferenceWaveNumber_1_m = 0.1;  ///< n0 of ISO 8608

/// The exponent of a road's spectrum: Gd(n) ~ n^-below up to the bend, n^-above beyond it.
struct Waviness {
  double below = 2.0;
  double above = 2.0;
  double bend_1_m = 0.0;  ///< 0: `below` everywhere

  bool is_two() const { return below == 2.0 && (above == 2.0 || bend_1_m == 0.0); }
};

/// A filter in the distance domain that bends the spectrum of a road of waviness 2 to another one: a ladder
/// of first-order sections, as many to the decade as |F|^2 ~ n^(2 - waviness) needs to hold within 5 % from
/// 0.01 to 10 1/m, but for a bend, which is round within an octave.  |F| = 1 at n0 = 0.1 1/m, were bends
/// sharp.
///
/// Source: A. Oustaloup et al., Frequency-band complex noninteger differentiator, IEEE Trans. Circuits and
/// Systems I 47 (2000) 25-39; sections discretised by the bilinear transform.
class WavinessFilter {
 public:
  /// @param grid_m  between samples
  explicit WavinessFilter(double grid_m) : grid_m_(grid_m) {}

  /// From the next sample on; the state stays.
  /// @param gain  further factor of the height
  void set(const Waviness& waviness, double gain);

  /// Two noises that go through the same filter.
  Eigen::Vector2d filter(Eigen::Vector2d noise);

  /// |F| of the discrete filter, the gain included.
  double magnitude(double wave_number_1_m) const;

 private:
  static constexpr int kSections = 9;
  /// y = now x + before x_last + keep y_last
  struct Section {
    double now = 1.0, before = 0.0, keep = 0.0;
    Eigen::Vector2d last_in = Eigen::Vector2d::Zero(), last_out = Eigen::Vector2d::Zero();
  };

  double grid_m_;
  double gain_ = 1.0;
  bool is_flat_ = true;  ///< F = gain
  std::array<Section, kSections> section_{};
};

}  // namespace roadbalance::sim

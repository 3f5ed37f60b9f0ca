#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/contact_patch.hpp"
#include "sim/obstacles.hpp"
#include "sim/random.hpp"
#include "sim/scenario.hpp"
#include "sim/waviness.hpp"

namespace roadbalance::sim {

/// Shape of the road's spectrum: height u = w2 / ((s + w1)(s + w2)) * white noise in the distance domain,
/// whose slope has the two-sided density 2 pi^2 n0^2 Gd(n0) between the corners, as ISO 8608 with exponent 2.
/// w1 = 2 pi * 0.01 1/m bounds the height, w2 = 2 pi kPatchWave_1_m is the contact patch.
struct RoadFilter {
  static constexpr double kGrid_m = 0.01;
  static constexpr double kLowCorner_rad_m = 2.0 * 3.14159265358979323846 * 0.01;
  static constexpr double kHighCorner_rad_m = 2.0 * 3.14159265358979323846 * kPatchWave_1_m;

  Eigen::Matrix2d transition;  ///< of [height, slope] over one grid cell
  Eigen::Matrix2d noise;       ///< Cholesky factor of what the white noise adds over one cell

  /// Exact, by C. Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23 (1978) 395.
  /// @param roughness_m3  Gd(n0), >= 0
  explicit RoadFilter(double roughness_m3);
};

/// The road that one wheel rolls over, in the distance domain: independent of speed.
///
/// The noise of a road cell is a pure function of seed, side and cell, so the rear wheel meets what the front
/// wheel met at the same place without anybody remembering it:
/// right = r left + sqrt(1 - r^2) own, rear = c front + sqrt(1 - c^2) own (with the same left/right r),
/// r = left_right_correlation, c^2 = rear_coherence2.  A filter of the stretch bends the spectrum of what is
/// left's, on the right, too, so that no side leads; of what is the right's own, another one, of the right's
/// exponents (waviness.hpp).  Between grid points the height is a cubic Hermite curve.  Joints and potholes
/// are added.
class RoadProfile {
 public:
  /// @param wheel    0 .. 3
  /// @param start_m  place where the profile is first asked for; it begins 200 m before
  RoadProfile(const RoadScenario& scenario, std::uint64_t seed, std::size_t wheel, double start_m);

  /// @param place_m  not more than 1 cm before the last one
  RoadPoint at(double place_m);

 private:
  struct Ingredient {
    RandomSequence random;
    double weight;
    bool is_rights;  ///< own
  };
  void advance();
  void begin_stretch(std::int64_t number);

  RoadScenario scenario_;
  RoadFilter filter_;
  WavinessFilter lefts_{RoadFilter::kGrid_m}, rights_{RoadFilter::kGrid_m};
  RandomSequence stretch_;
  std::int64_t cells_a_stretch_;
  std::vector<Ingredient> ingredient_;
  Obstacles joints_, potholes_;
  std::int64_t cell_;          ///< `from_` is the road at cell_ * kGrid_m
  Eigen::Vector2d from_, to_;  ///< [height, slope] at both ends of the cell
};

}  // namespace roadbalance::sim

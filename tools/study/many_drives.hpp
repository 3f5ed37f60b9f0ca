#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace roadbalance {

/// Drives of one car on other days: each of two speeds of its own between 80 and 130 km/h, on a road of its
/// own, of class A, B, A, C in turn.
struct ManyDrives {
  int drives = 16;
  double seconds = 40.0;  ///< at each speed
  /// By which the car itself differs from drive to drive, one standard deviation: the tyres' stiffness, all
  /// four alike, and each component of each wheel's unbalance.
  double tyre_percent = 0.0, unbalance_g = 0.0;
};

/// Ways to join the drives.
enum class Joined { kProduct, kNotWidened, kPlainSums };
inline constexpr Joined kJoined[] = {Joined::kProduct, Joined::kNotWidened, Joined::kPlainSums};

/// A quarter of the drives, half of them, all.
std::vector<int> joined_sizes(int drives);

/// The key of many_drives_run() for so many of the drives.
std::string joined_key(Joined joined, int drives);

/// One car, drawn by the seed: springs, dampers, stabilisers and tyres of each axle within +- 10 % of what
/// vehicle.toml has.  Its drives behind perfect sensors with white noise of 0.02 m/s^2, each through sections
/// and weights as the product does, put into one estimate.
///
/// By joined_key() a wheel each of
///
///     {"off_g": [along the unbalance, across], "ellipse": e' C^-1 e of the stated covariance C,
///      "sigma_g": root of half the trace of C, "tyre_percent", "tyre_sigmas": error by stated deviation,
///      "ratio": JointDrives::drives_ratio}
///
/// against the mean of what the drives had; null where nothing is known.
nlohmann::ordered_json many_drives_run(const ManyDrives& drives, std::uint64_t seed);

}  // namespace roadbalance

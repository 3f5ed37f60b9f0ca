#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/vehicle/linear_model.hpp"
#include "tools/study/cramer_rao.hpp"

namespace roadbalance {

/// A drive of the simulated car with everything that goes wrong in sensors and encoders, put to the whole
/// identification: nodes, blocks, 96-tooth rings with pitch errors of 0.3 degrees and stamps that jitter by 5
/// us, noise of 0.02 m/s^2, 16 bits, a car whose springs, dampers, stabilisers and tyres are drawn within
/// +-10 %.
struct ChainDrive {
  std::string road_class = "A";
  double rear_coherence2 = 0.95;
  std::vector<double> speeds_km_h{110.0, 116.7, 123.3, 130.0};
  double seconds = 40.0;  ///< at each speed, beside the change to it and what filters need to settle
  std::array<double, kWheels> unbalance_g{30.0, 20.0, 25.0, 15.0};
  std::array<double, kWheels> radial_force_n{};
};

/// The least standard deviations of estimates from such a drive (cramer_rao): tyres, unbalances and the
/// road's exponent unknown, all else known.
std::array<WheelBound, kWheels> chain_bound(const ChainDrive& drive);

/// Results against the truth; one object a wheel:
///
///     {"name", "told", "mass_percent", "angle_deg", "residual_g": what an ideal counterweight leaves,
///      "rounded_g": what the product's weights leave, in steps of 5 g,
///      "tyre_percent", "ellipse": (x - truth)' C^-1 (x - truth) of the stated covariance C,
///      "force_state", "alone_residual_g", "sigma_alone_g", "force_error_n", "sigma_force_n"}
///
/// null where nothing is known.  "alone" is the unbalance without the radial force, where speeds separate
/// them.
/// @param folder  for the scenario's file
nlohmann::ordered_json chain_errors(const ChainDrive& drive, std::uint64_t seed,
                                    const std::filesystem::path& folder);

/// One kind of number, of all runs under `key` and one wheel, or with wheel -1 all; NaN where nothing is
/// known.
std::vector<double> chain_values(const std::vector<nlohmann::ordered_json>& runs, const std::string& key,
                                 int wheel, const char* what);

}  // namespace roadbalance

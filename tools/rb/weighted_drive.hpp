#pragma once

#include <complex>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// A recording and the weights that were on a rotor then, as people type them:
/// DIR, or DIR:PLANE=GRAMS@DEGREES[,PLANE=GRAMS@DEGREES ...].  A folder may have colons and = in its path;
/// what follows the last colon and has a = but no slash are weights.
struct WeightedDrive {
  std::string folder;
  struct Weight {
    std::string plane;
    std::complex<double> weight_g;  ///< at its angle
  };
  std::vector<Weight> weight;

  /// @throws ConfigError saying what is wrong with it and what is allowed
  static WeightedDrive parse(const std::string& text);

  /// [plane] of the rotor; weights in one plane add up.
  /// @throws ConfigError naming a plane that the rotor does not have, and those it has
  std::vector<std::complex<double>> in_planes(const RotorConfig& rotor) const;
};

}  // namespace roadbalance

#include "host/analysis/identify/confidence.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {

double few_groups_factor(double groups) {
  const double quantile = (groups - 1.0) * (std::pow(0.05, -2.0 / (groups - 2.0)) - 1.0);
  return quantile / kChiSquared95;
}

double few_drives_factor(double drives) {
  // F(2, m) has the quantile m / 2 (0.05^(-2/m) - 1), and chi^2 is twice an F(2, infinity).
  const double half = std::max(1.0, drives - 1.0);
  return 2.0 * half * (std::pow(0.05, -1.0 / half) - 1.0) / kChiSquared95;
}

}  // namespace roadbalance

#include "host/identify/confidence.hpp"

#include <cmath>

namespace roadbalance {

double few_groups_factor(double groups) {
  const double quantile = (groups - 1.0) * (std::pow(0.05, -2.0 / (groups - 2.0)) - 1.0);
  return quantile / kChiSquared95;
}

}  // namespace roadbalance

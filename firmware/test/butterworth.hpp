#pragma once

#include <complex>
#include <numbers>

#include "common/config/vehicle_config.hpp"

namespace roadbalance::test {

/// Butterworth's response, from its poles on the circle: independent of the product's state space.
inline std::complex<double> response(const FilterConfig& filter, double hz) {
  std::complex<double> product = 1.0;
  for (int k = 1; k <= filter.order; ++k)
    product /=
        1.0 - std::complex(0.0, hz / filter.cutoff_hz) /
                  std::polar(1.0, std::numbers::pi * (2 * k + filter.order - 1) / (2.0 * filter.order));
  return product;
}

}  // namespace roadbalance::test

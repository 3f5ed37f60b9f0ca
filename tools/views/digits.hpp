#pragma once

#include <algorithm>
#include <cmath>

namespace roadbalance {

/// Decimals that a value with this standard deviation is worth: two digits of the sigma, 12.3 of +- 1.4 and
/// 0.0665 of +- 0.0031.  A sigma that is 0 or unknown gives one.
inline int decimals_by(double sigma) {
  constexpr int kMost = 12;
  if (!(sigma > 0.0) || !std::isfinite(sigma)) return 1;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, kMost);
}

}  // namespace roadbalance

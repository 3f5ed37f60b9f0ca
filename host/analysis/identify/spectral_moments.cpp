#include "host/analysis/identify/spectral_moments.hpp"

#include "common/types/angle_units.hpp"

namespace roadbalance {

SpectralMoments& SpectralMoments::operator+=(const SpectralMoments& other) {
  if (other.segments == 0.0) return *this;
  if (segments == 0.0) return *this = other;
  delay_seconds += other.delay_seconds;
  segments += other.segments;
  count += other.count;
  for (std::size_t k = 0; k < same.size(); ++k) {
    same[k] += other.same[k];
    delayed[k] += other.delayed[k];
  }
  return *this;
}

double SpectralMoments::omega(Eigen::Index bin) const {
  return kTurn * step_hz * static_cast<double>(first + bin);
}

}  // namespace roadbalance

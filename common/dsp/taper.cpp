#include "common/dsp/taper.hpp"

#include <stdexcept>

namespace roadbalance {

Taper c2_taper(Eigen::Index samples, double fraction, double step_s) {
  if (samples < 2 || !(fraction > 0.0 && fraction <= 0.5) || !(step_s > 0.0))
    throw std::invalid_argument("taper needs samples >= 2, 0 < fraction <= 0.5, step > 0");
  Taper taper{Eigen::ArrayXd::Ones(samples), Eigen::ArrayXd::Zero(samples), Eigen::ArrayXd::Zero(samples)};
  const double rise = fraction * static_cast<double>(samples);  // in samples
  for (Eigen::Index k = 0; k < samples; ++k) {
    const bool rising = 2 * k < samples;
    const double x = (static_cast<double>(rising ? k : samples - 1 - k) + 0.5) / rise;
    if (x >= 1.0) continue;
    const double slope = (rising ? 1.0 : -1.0) / (rise * step_s);  // dx/dt
    taper.value(k) = x * x * x * (10.0 + x * (-15.0 + 6.0 * x));
    taper.first(k) = 30.0 * x * x * (1.0 - x) * (1.0 - x) * slope;
    taper.second(k) = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) * slope * slope;
  }
  return taper;
}

}  // namespace roadbalance

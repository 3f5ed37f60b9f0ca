#include "host/analysis/orders/anti_aliasing.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "common/dsp/linear_filter.hpp"

namespace roadbalance {
namespace {

std::complex<double> s_of(double frequency_hz) {
  return {0.0, 2.0 * std::numbers::pi * frequency_hz};
}

}  // namespace

AntiAliasing::AntiAliasing(const FilterConfig& filter)
    : poles_(butterworth(filter.order, filter.cutoff_hz).F.eigenvalues()) {
  // |H|^2 = 1 / (1 + (f / fc)^(2 n)) = 0.99^2
  flat_to_hz_ = filter.cutoff_hz * std::pow(1.0 / (0.99 * 0.99) - 1.0, 0.5 / filter.order);
}

std::complex<double> AntiAliasing::response(double frequency_hz) const {
  std::complex<double> product = 1.0;
  for (const auto& pole : poles_) product /= 1.0 - s_of(frequency_hz) / pole;
  return product;
}

/// Pole by pole it is never beyond half a turn and so needs no unwrapping.
double AntiAliasing::phase_rad(double frequency_hz) const {
  double sum = 0.0;
  for (const auto& pole : poles_) sum -= std::arg(1.0 - s_of(frequency_hz) / pole);
  return sum;
}

std::complex<double> AntiAliasing::on_order(double order, double rotation_hz) const {
  return response(order * rotation_hz) * std::polar(1.0, -order * phase_rad(rotation_hz));
}

}  // namespace roadbalance

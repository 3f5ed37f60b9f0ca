#pragma once

#include "tools/study/exact_covariance.hpp"

namespace roadbalance::test {

/// The car of the derivation; its places and values are those of the published tables.
inline const Geometry kReferenceGeometry{{1.25, 1.25, -1.45, -1.45}, {0.74, -0.74, 0.74, -0.74}};
inline ParameterVector reference_car() {
  ParameterVector p = ParameterVector::Zero();
  p.head<kTyre + kWheels>() << 1300, 480, 2200, 34, 34, 32, 32, 22000, 21000, 24000, 25000, 1500, 1400, 1600,
      1700, 12000, 5000, 215000, 205000, 210000, 220000;
  return p;
}
inline const std::array<std::complex<double>, kWheels> kReferenceUnbalance{
    std::polar(0.035 * 0.19, 3.79), std::polar(0.02 * 0.19, 1.05), std::polar(0.012 * 0.19, -0.4),
    std::polar(0.015 * 0.19, 2.2)};

/// It, driving over four independent roads of class A by default.
inline ExactDrive reference_drive(double speed_km_h, int order = 5, double corner_hz = 30.0,
                                  double road_gd_m3 = 16e-6) {
  return ExactDrive(kReferenceGeometry, reference_car(), kReferenceUnbalance, speed_km_h / 3.6, 0.30,
                    road_gd_m3, butterworth(order, corner_hz), corner_hz);
}

}  // namespace roadbalance::test

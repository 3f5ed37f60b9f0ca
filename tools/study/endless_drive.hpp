#pragma once

#include <array>
#include <complex>
#include <optional>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/estimate.hpp"
#include "host/analysis/identify/instruments.hpp"
#include "host/analysis/identify/whittle_moments.hpp"
#include "tools/study/exact_covariance.hpp"

namespace roadbalance {

/// The demonstration car at four speeds of 110 .. 130 km/h on four independent roads of class A, without
/// end and without noise: phasors of its accelerations and all moments, exactly.  The error that remains is
/// bias.
class EndlessDrive {
 public:
  /// @param unbalance  of the wheels, kg m
  explicit EndlessDrive(const std::array<std::complex<double>, kWheels>& unbalance);

  const VehicleConfig& vehicle() const { return vehicle_; }

  /// Apparent unbalance in a wheel's row at the order of wheel `of`, every parameter taken as known, kg m:
  /// U = row(Om) Z'' / Om^2 by (1), speeds weighted by Om^4 as an unbalance's force asks.  At another wheel's
  /// order it should be 0.
  /// @param geometry  as it is taken for known, here and below: that of vehicle() is true
  std::complex<double> fixed(const Geometry& geometry, const ParameterVector& known, int wheel, int of) const;

  /// By solve(): suspension and tyres identified from the same drive.
  std::optional<UnknownVector> identified(const Geometry& geometry, const ParameterVector& known) const;
  /// The same with tyres by whittle_tyres().
  std::optional<UnknownVector> identified_by_likelihood(const Geometry& geometry,
                                                        const ParameterVector& known) const;

 private:
  ExactDrive at(double speed_m_s, const Instrument& instrument,
                const std::array<std::complex<double>, kWheels>& unbalance) const;
  WhittleMoments spectra(const ExactDrive& drive, double speed_m_s) const;
  DriveMoments moments() const;

  VehicleConfig vehicle_;
  Geometry geometry_;
  std::vector<ExactDrive> chassis_, tyre_;
  std::vector<WhittleMoments> spectra_;
};

}  // namespace roadbalance

#include "tools/study/endless_drive.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "host/analysis/identify/unbalances.hpp"
#include "host/analysis/identify/whittle.hpp"
#include "tools/study/estimator_trial.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kClassA = 16e-6, kTyreRadius_m = 0.30;

void add(DriveMoments& sum, const ExactDrive& chassis, const ExactDrive& tyre) {
  const double chassis_lag_s = chassis_instrument().lag_s, tyre_lag_s = tyre_instrument().lag_s;
  sum.sections += 10;
  for (int j = 0; j < kChassisInstrumentsPerSignal; ++j)
    for (int c = 0; c < kCoordinates; ++c) {
      const auto i = static_cast<std::size_t>(j * kCoordinates + c);
      sum.chassis[i] += chassis.moments(c, j, chassis_lag_s);
      sum.chassis_power[i] += chassis.power(c, j);
    }
  for (int w = 0; w < kWheels; ++w) {
    auto& wheel = sum.wheel[static_cast<std::size_t>(w)];
    wheel.tyre += tyre.moments(kBodyCoordinates + w, 0, tyre_lag_s);
    wheel.tyre_unbalance += tyre.with_reference(kBodyCoordinates + w, 0, tyre_lag_s, w);
    const double om = tyre.omega(w);
    const Eigen::RowVectorXcd Z = tyre.acceleration_phasor(w).transpose();
    sum.harmonic.right[static_cast<std::size_t>(w)][static_cast<std::size_t>(w)] +=
        {om * om * Z, om * Z * Complex(0.0, 1.0), -Z};
    sum.harmonic.normal(w, w) += om * om * om * om;
  }
}

}  // namespace

EndlessDrive::EndlessDrive(const std::array<Complex, kWheels>& unbalance)
    : vehicle_(demo_vehicle()), geometry_(geometry_of(vehicle_.model)) {
  for (const double speed_m_s : speeds_between(110.0, 130.0, 4)) {
    chassis_.push_back(at(speed_m_s, chassis_instrument(), unbalance));
    tyre_.push_back(at(speed_m_s, tyre_instrument(), unbalance));
    spectra_.push_back(spectra(tyre_.back(), speed_m_s));
  }
}

ExactDrive EndlessDrive::at(double speed_m_s, const Instrument& instrument,
                            const std::array<Complex, kWheels>& unbalance) const {
  return {geometry_,         nominal_parameters(vehicle_), unbalance, speed_m_s, kTyreRadius_m, kClassA,
          instrument.filter, instrument.corner_hz};
}

/// Bins as WhittleGatherer takes them, each expected once: the road's spectral density through (1), of which
/// a factor common to all bins of a speed is free.
WhittleMoments EndlessDrive::spectra(const ExactDrive& drive, double speed_m_s) const {
  const LinearModel model = linear_model(geometry_, nominal_parameters(vehicle_));
  const double turn = 2.0 * std::numbers::pi;
  const double least = turn * ExactDrive::kLeastWave_1_m * speed_m_s;
  const double patch = turn * kPatchWave_1_m * speed_m_s;
  WhittleMoments sum;
  const double step_hz = 1.0 / kWhittleSegment_s;
  sum.segments = 1.0;
  sum.delay_seconds = (geometry_.x_m[0] - geometry_.x_m[2]) / speed_m_s;
  const Eigen::Index bins = std::lround((kWhittleTo_hz - kWhittleFrom_hz) / step_hz) + 1;
  sum.frequency_hz = Eigen::ArrayXd::LinSpaced(bins, kWhittleFrom_hz, kWhittleTo_hz);
  sum.count.setOnes(bins);
  for (Eigen::Index k = 0; k < bins; ++k) {
    const double om = sum.omega(k);
    const Eigen::Matrix<Complex, kCoordinates, kCoordinates> dynamic =
        model.Q.cast<Complex>() + Complex(0.0, om) * model.P.cast<Complex>() -
        (om * om * model.M).cast<Complex>();
    const Eigen::Matrix<Complex, kCoordinates, kWheels> Z = dynamic.partialPivLu().solve(
        -om * om * (model.S.cast<Complex>() + Complex(0.0, om) * model.Sd.cast<Complex>()));
    const double density = 1.0 / ((om * om + least * least) * (1.0 + om * om / (patch * patch)));
    for (int i = 0; i < kWheels; ++i)  // no line is in the spectrum here, but its bins do not count there
      if (std::abs(om - drive.omega(i)) < kLineBins * turn * step_hz) sum.count(k) = 0.0;
    sum.same.emplace_back(sum.count(k) * density * Z * Z.adjoint());
    sum.delayed.emplace_back(std::polar(1.0, -om * sum.delay_seconds) * sum.same.back());
  }
  return sum;
}

Complex EndlessDrive::fixed(const Geometry& geometry, const ParameterVector& known, int wheel, int of) const {
  const LinearModel model = linear_model(geometry, known);
  const int row = kBodyCoordinates + wheel;
  Complex sum = 0.0;
  double weight = 0.0;
  for (const ExactDrive& drive : tyre_) {
    const double om = drive.omega(of);
    const Eigen::VectorXcd Z = drive.acceleration_phasor(of);
    const Eigen::RowVectorXcd dynamic = model.M.row(row).cast<Complex>() +
                                        model.P.row(row) * Complex(0.0, -1.0 / om) -
                                        (model.Q.row(row) / (om * om)).cast<Complex>();
    sum += om * om * (dynamic * Z).value();
    weight += om * om * om * om;
  }
  return sum / weight;
}

DriveMoments EndlessDrive::moments() const {
  DriveMoments sum;
  for (std::size_t s = 0; s < tyre_.size(); ++s) add(sum, chassis_[s], tyre_[s]);
  return sum;
}

std::optional<UnknownVector> EndlessDrive::identified(const Geometry& geometry,
                                                      const ParameterVector& known) const {
  return solve(moments(), geometry, known);
}

std::optional<UnknownVector> EndlessDrive::identified_by_likelihood(const Geometry& geometry,
                                                                    const ParameterVector& known) const {
  auto x = identified(geometry, known);
  if (!x) return x;
  ParameterVector parameters = known;
  parameters.segment<kEstimatedUnbalance>(kSpring) = x->head<kEstimatedUnbalance>();
  parameters.segment<kWheels>(kTyre) = known.segment<kWheels>(kTyre);
  std::vector<const WhittleMoments*> speeds;
  for (const WhittleMoments& speed : spectra_) speeds.push_back(&speed);
  const auto tyres = whittle_tyres(speeds, geometry, parameters, std::bitset<kWheels>().set());
  if (!tyres) return std::nullopt;
  parameters.segment<kWheels>(kTyre).setZero();
  const Unbalances unbalances = solve_unbalances(moments().harmonic, geometry, parameters);
  x->segment<kWheels>(kEstimatedTyre) = tyres->tyre_n_m;
  put_unbalances(unbalances.at(tyres->tyre_n_m), unbalances.found, UnknownSet().set(), *x);
  return x;
}

}  // namespace roadbalance

// A computed unbalance is added to what a real road did to a real car, and found again.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "common/dsp/taper.hpp"
#include "common/test/source.hpp"
#include "common/vehicle/unbalance_response.hpp"
#include "host/analysis/identify/demodulation.hpp"
#include "host/analysis/identify/estimators/estimator.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// Vertical accelerations of the front knuckles, left and right, a column a sample.  The stamps are those of
/// a serial port, bunched; the converter was not: samples are taken as even at their mean rate, as rb import
/// does.
struct MeasuredRoad {
  double rate_hz = 0.0;
  Eigen::Matrix2Xd knuckle;
};
MeasuredRoad measured_road() {
  std::istringstream file(test::read_source("tools/rb/test/data/wobbletracker_knuckles.csv"));
  std::string line;
  std::getline(file, line), std::getline(file, line);  // names, units
  std::vector<std::array<double, 3>> rows;
  for (std::array<double, 3> row{}; std::getline(file, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    numbers >> row[0] >> row[2] >> row[1];  // passenger is right, driver is left
    rows.push_back(row);
  }
  MeasuredRoad road{static_cast<double>(rows.size() - 1) / (rows.back()[0] - rows.front()[0]),
                    Eigen::Matrix2Xd(2, std::ssize(rows))};
  for (Eigen::Index k = 0; k < road.knuckle.cols(); ++k)
    for (int side = 0; side < 2; ++side)
      road.knuckle(side, k) = rows[static_cast<std::size_t>(k)][static_cast<std::size_t>(1 + side)];
  road.knuckle.colwise() -= road.knuckle.rowwise().mean().eval();
  return road;
}

VehicleConfig land_cruiser() {
  return VehicleConfig::read_file(test::source_path("tools/rb/test/data/wobbletracker.toml"));
}

/// The car of vehicle.toml as an unbalanced wheel shakes it: Newton's equations of five bodies, strut by
/// strut, integrated by the classical Runge-Kutta method.  No matrix of the identification is used.
class ShakenCar {
 public:
  /// @param unbalance_kg_m  of that wheel, which turns at omega
  ShakenCar(const VehicleConfig& car, std::size_t wheel, Complex unbalance_kg_m, double omega)
      : car_(car), wheel_(wheel), force_n_(unbalance_kg_m * omega * omega), omega_(omega) {}

  /// z'' at `samples` instants from time 0, at which the wheel's angle is 0, a column each; it has been
  /// shaken for 5 s before: the slowest mode has decayed by e^-10.
  Eigen::Matrix<double, kCoordinates, Eigen::Dynamic> shake(Eigen::Index samples, double rate_hz) const {
    constexpr int kSteps = 8;  // 1 ms: the wheels' 9 Hz to 1e-6
    const double h = 1.0 / (kSteps * rate_hz);
    Eigen::Matrix<double, kCoordinates, Eigen::Dynamic> motion(kCoordinates, samples);
    State s = State::Zero();
    const auto run_in = static_cast<Eigen::Index>(5.0 * rate_hz);
    for (Eigen::Index k = -run_in; k < samples; ++k) {
      const double t = static_cast<double>(k) / rate_hz;
      if (k >= 0) motion.col(k) = rate(t, s).tail<kCoordinates>();
      for (int i = 0; i < kSteps; ++i) step(t + i * h, h, s);
    }
    return motion;
  }

 private:
  using State = Eigen::Matrix<double, 2 * kCoordinates, 1>;  // z, z'

  State rate(double t, const State& s) const {
    std::array<double, kWheels> pull{};  // of each strut on body and wheel, together
    Eigen::Vector3d body = Eigen::Vector3d::Zero();
    State change;
    change.head<kCoordinates>() = s.tail<kCoordinates>();
    const auto stretch = [&](std::size_t i, int of) {
      const AxleConfig& axle = car_.model.axle[i / 2];
      const double y_m = i % 2 == 0 ? axle.half_track_m : -axle.half_track_m;
      return s(of) + y_m * s(of + 1) - axle.x_m * s(of + 2) - s(of + 3 + static_cast<int>(i));
    };
    for (std::size_t i = 0; i < kWheels; ++i) {
      const AxleConfig& axle = car_.model.axle[i / 2];
      const std::size_t other = i ^ 1U;
      pull[i] = axle.spring_n_m * stretch(i, 0) + axle.damper_n_s_m * stretch(i, kCoordinates) +
                axle.stabiliser_n_m * (stretch(i, 0) - stretch(other, 0));
      const double y_m = i % 2 == 0 ? axle.half_track_m : -axle.half_track_m;
      body -= pull[i] * Eigen::Vector3d(1.0, y_m, -axle.x_m);
      const double unbalance = i == wheel_ ? (force_n_ * std::polar(1.0, omega_ * t)).real() : 0.0;
      const int row = kBodyCoordinates + static_cast<int>(i);
      change(kCoordinates + row) = (pull[i] - axle.tyre_n_m * s(row) + unbalance) / car_.wheel[i].mass_kg;
    }
    change.segment<3>(kCoordinates) << body(0) / car_.model.body_mass_kg,
        body(1) / car_.model.roll_inertia_kg_m2, body(2) / car_.model.pitch_inertia_kg_m2;
    return change;
  }

  void step(double t, double h, State& s) const {
    const State k1 = rate(t, s), k2 = rate(t + h / 2, s + h / 2 * k1), k3 = rate(t + h / 2, s + h / 2 * k2),
                k4 = rate(t + h, s + h * k3);
    s += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }

  VehicleConfig car_;
  std::size_t wheel_;
  Complex force_n_;
  double omega_;
};

/// A piece of the measured road with that car's shaking on it, and the wheel's angle.
Stretch with_unbalance(const VehicleConfig& car, const MeasuredRoad& road, Eigen::Index begin,
                       Eigen::Index samples, int wheel, double km_h, Complex unbalance) {
  const auto w = static_cast<std::size_t>(wheel);
  Stretch stretch{.rate_hz = road.rate_hz, .speed_m_s = km_h / 3.6, .signals = {}, .road_m = {}};
  stretch.omega(wheel) = stretch.speed_m_s / car.wheel[w].rolling_radius_m;
  stretch.signals = SignalMatrix::Zero(kSignals, samples);
  stretch.signals.topRows<kCoordinates>() =
      ShakenCar(car, w, unbalance, stretch.omega(wheel)).shake(samples, road.rate_hz);
  stretch.signals.middleRows<2>(kBodyCoordinates) += road.knuckle.middleCols(begin, samples);
  for (Eigen::Index k = 0; k < samples; ++k) {
    const Complex r = std::polar(1.0, stretch.omega(wheel) * static_cast<double>(k) / road.rate_hz);
    stretch.signals(cosine_row(wheel), k) = r.real();
    stretch.signals(sine_row(wheel), k) = r.imag();
  }
  return stretch;
}

/// Response of the model's equations to a unit unbalance at the wheel itself.
Complex own_response(const VehicleConfig& car, int wheel, double omega) {
  const LinearModel model = linear_model(geometry_of(car.model), nominal_parameters(car));
  return unbalance_response(model, wheel, omega)(kBodyCoordinates + wheel);
}

/// Errors against what was predicted: |error|^2 over its mean is exponential with mean 1.
struct Ratios {
  double sum = 0.0, greatest = 0.0;
  int cases = 0, within = 0;
  void add(double ratio) {
    sum += ratio;
    greatest = std::max(greatest, ratio);
    within += ratio <= -std::log(0.05);
    ++cases;
  }
};

/// 100 g at 0.18 m on a front wheel, at many speeds and phases, in three pieces of the drive; the spectrum
/// beside the line predicts the error of the result.
TEST(SemiReal, DemodulationFindsAnUnbalanceWithTheErrorThatItsSpectrumPredicts) {
  const VehicleConfig car = land_cruiser();
  const MeasuredRoad road = measured_road();
  ASSERT_NEAR(road.rate_hz, 117.0, 2.0);
  const auto samples = static_cast<Eigen::Index>(10.0 * road.rate_hz);
  const Demodulator demodulator(c2_taper(samples, 0.1, 1.0 / road.rate_hz), road.rate_hz);
  Ratios ratios;
  for (int wheel = 0; wheel < 2; ++wheel)
    for (Eigen::Index begin = 0; begin + samples <= road.knuckle.cols(); begin += samples)
      for (double km_h = 60.0; km_h < 111.0; km_h += 2.0) {
        const Complex unbalance = std::polar(0.1 * 0.18, 0.7 * ratios.cases);
        const Stretch stretch = with_unbalance(car, road, begin, samples, wheel, km_h, unbalance);
        const Complex unit = own_response(car, wheel, stretch.omega(wheel));
        const Demodulated line = demodulator(stretch.signals, stretch.omega);
        const int row = kBodyCoordinates + wheel;
        const double predicted =
            demodulator.beside(stretch.signals, line).col(row).cwiseAbs2().mean() / std::norm(unit);
        ratios.add(std::norm(line.Z(0, row) / unit - unbalance) / predicted);
      }
  ASSERT_GE(ratios.cases, 100);
  RecordProperty("cases", ratios.cases);
  // Neighbouring speeds are 0.23 Hz apart, lines 0.1 Hz wide: nearly independent.
  EXPECT_NEAR(ratios.sum / ratios.cases, 1.0, 0.3);
  EXPECT_NEAR(static_cast<double>(ratios.within) / ratios.cases, 0.95, 0.06);
  EXPECT_LT(std::sqrt(ratios.greatest), 3.5);
}

/// Mean square of a phasor of what shakes the knuckle about a frequency, under a taper: of a periodogram with
/// Hann's window over the 2 Hz on either side.
double phasor_power(const Eigen::Ref<const Eigen::RowVectorXd>& knuckle, double rate_hz, double hz,
                    const Eigen::VectorXd& taper) {
  const Eigen::Index n = knuckle.size();
  double density = 0.0;
  int bins = 0;
  for (double at_hz = hz - 2.0; at_hz <= hz + 2.0; at_hz += rate_hz / static_cast<double>(n), ++bins) {
    Complex sum = 0.0;
    for (Eigen::Index k = 0; k < n; ++k) {
      const double turns = static_cast<double>(k) / static_cast<double>(n);
      sum += knuckle(k) * (1.0 - std::cos(2.0 * pi * turns)) *
             std::polar(1.0, -2.0 * pi * at_hz * static_cast<double>(k) / rate_hz);
    }
    density += std::norm(sum) / (1.5 * static_cast<double>(n));  // of white noise of power 1: 1
  }
  return density / bins * 4.0 * taper.squaredNorm() / (taper.sum() * taper.sum());
}

/// Three pieces at three speeds together, through the estimator as `rb identify --estimator correlation` has
/// it: least squares over the speeds, whose error follows from the spectra of what was measured alone.
TEST(SemiReal, CorrelationFindsAnUnbalanceWithTheErrorThatTheMeasuredSpectraPredict) {
  const VehicleConfig car = land_cruiser();
  const MeasuredRoad road = measured_road();
  const auto samples = static_cast<Eigen::Index>(10.0 * road.rate_hz);
  const Eigen::VectorXd taper = c2_taper(samples, 0.2, 1.0 / road.rate_hz).value;
  Ratios ratios;
  for (int wheel = 0; wheel < 2; ++wheel)
    for (const double least_km_h : {60.0, 62.0, 64.0, 66.0, 84.0, 86.0, 88.0, 90.0})
      for (int turned = 0; turned < 3; ++turned) {  // each piece at each speed once
        Question question{.geometry = geometry_of(car.model), .known = nominal_parameters(car), .asked = {}};
        question.asked.set(static_cast<std::size_t>(kEstimatedUnbalance + 2 * wheel));
        question.asked.set(static_cast<std::size_t>(kEstimatedUnbalance + 2 * wheel + 1));
        const auto estimator = make_estimator("correlation", question);
        const Complex unbalance = std::polar(0.1 * 0.18, 0.7 * ratios.cases);
        double of_noise = 0.0, power = 0.0;
        for (int piece = 0; piece < 3; ++piece) {
          const double km_h = least_km_h + 8.0 * ((piece + turned) % 3);
          const Stretch stretch = with_unbalance(car, road, piece * samples, samples, wheel, km_h, unbalance);
          estimator->add(stretch);
          const double h2 = std::norm(own_response(car, wheel, stretch.omega(wheel)));
          of_noise += h2 * phasor_power(road.knuckle.row(wheel).segment(piece * samples, samples),
                                        road.rate_hz, stretch.omega(wheel) / (2.0 * pi), taper);
          power += h2;
        }
        const EstimatorAnswer answer = estimator->solve();
        const Complex found(answer.x(kEstimatedUnbalance + 2 * wheel),
                            answer.x(kEstimatedUnbalance + 2 * wheel + 1));
        ratios.add(std::norm(found - unbalance) / (of_noise / (power * power)));
      }
  ASSERT_EQ(ratios.cases, 48);
  // 3 standard deviations of the mean of 48 independent exponentials.
  EXPECT_NEAR(ratios.sum / ratios.cases, 1.0, 3.0 / std::sqrt(48.0));
  EXPECT_NEAR(static_cast<double>(ratios.within) / ratios.cases, 0.95, 3.0 * std::sqrt(0.95 * 0.05 / 48.0));
  EXPECT_LT(std::sqrt(ratios.greatest), 3.5);
}

// Without a road there is no error: integration of the unbalance gives the response of the model.
TEST(SemiReal, TheIntegratedCarAnswersAsTheModelSays) {
  const VehicleConfig car = land_cruiser();
  MeasuredRoad road = measured_road();
  road.knuckle.setZero();
  const Complex unbalance = std::polar(0.1 * 0.18, 0.7);
  const Stretch stretch = with_unbalance(car, road, 0, 1170, 1, 90.0, unbalance);
  const Demodulator demodulator(c2_taper(1170, 0.1, 1.0 / road.rate_hz), road.rate_hz);
  const Demodulated line = demodulator(stretch.signals, stretch.omega);
  const Complex found = line.Z(0, kBodyCoordinates + 1) / own_response(car, 1, stretch.omega(1));
  EXPECT_LT(std::abs(found - unbalance), 1e-4 * std::abs(unbalance));
}

}  // namespace
}  // namespace roadbalance

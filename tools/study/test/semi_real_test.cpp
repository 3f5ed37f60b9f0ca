// A computed unbalance is added to what a real road did to a real car, and found again.
#include <gtest/gtest.h>

#include <Eigen/LU>
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
#include "common/vehicle/linear_model.hpp"
#include "host/identify/demodulation.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;

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

/// Phasors of z'' of a unit unbalance of one wheel.
Eigen::VectorXcd response(const VehicleConfig& car, int wheel, double omega) {
  const LinearModel model = linear_model(geometry_of(car.model), nominal_parameters(car));
  const Eigen::MatrixXcd dynamic = model.Q + Complex(0.0, omega) * model.P - omega * omega * model.M;
  return -std::pow(omega, 4) * dynamic.partialPivLu().solve(model.W.col(wheel).cast<Complex>());
}

/// 100 g at 0.18 m on a front wheel, at many speeds and phases, in three pieces of the drive.  The spectrum
/// beside the line says how far off the result will be: |error|^2 over it is exponential with mean 1.
TEST(SemiReal, FindsAnUnbalanceInMeasuredVibrationWithTheErrorThatItsSpectrumPredicts) {
  const auto car = VehicleConfig::read_file(test::source_path("tools/rb/test/data/wobbletracker.toml"));
  const MeasuredRoad road = measured_road();
  ASSERT_NEAR(road.rate_hz, 117.0, 2.0);
  const auto samples = static_cast<Eigen::Index>(10.0 * road.rate_hz);
  const Demodulator demodulator(c2_taper(samples, 0.1, 1.0 / road.rate_hz), road.rate_hz);
  double sum = 0.0, greatest = 0.0;
  int cases = 0, within = 0;
  for (int wheel = 0; wheel < 2; ++wheel)
    for (Eigen::Index begin = 0; begin + samples <= road.knuckle.cols(); begin += samples)
      for (double km_h = 60.0; km_h < 111.0; km_h += 2.0) {
        const double omega = km_h / 3.6 / car.wheel[static_cast<std::size_t>(wheel)].rolling_radius_m;
        const Complex unbalance = std::polar(0.1 * 0.18, 0.7 * cases);
        const Eigen::VectorXcd unit = response(car, wheel, omega);
        SignalMatrix signals = SignalMatrix::Zero(kSignals, samples);
        signals.middleRows<2>(kBodyCoordinates) = road.knuckle.middleCols(begin, samples);
        for (Eigen::Index k = 0; k < samples; ++k) {
          const Complex r = std::polar(1.0, omega * static_cast<double>(k) / road.rate_hz);
          signals.col(k).head<kCoordinates>() += (unit * unbalance * r).real();
          signals(cosine_row(wheel), k) = r.real();
          signals(sine_row(wheel), k) = r.imag();
        }
        Eigen::Vector4d rates = Eigen::Vector4d::Zero();
        rates(wheel) = omega;
        const Demodulated line = demodulator(signals, rates);
        const int row = kBodyCoordinates + wheel;
        const Complex found = line.Z(0, row) / unit(row);
        const double predicted =
            demodulator.beside(signals, line).col(row).cwiseAbs2().mean() / std::norm(unit(row));
        const double ratio = std::norm(found - unbalance) / predicted;
        sum += ratio;
        greatest = std::max(greatest, ratio);
        within += ratio <= -std::log(0.05);
        ++cases;
      }
  ASSERT_GE(cases, 100);
  RecordProperty("cases", cases);
  // Neighbouring speeds are 0.23 Hz apart, lines 0.1 Hz wide: nearly independent.
  EXPECT_NEAR(sum / cases, 1.0, 0.3);
  EXPECT_NEAR(static_cast<double>(within) / cases, 0.95, 0.06);
  EXPECT_LT(std::sqrt(greatest), 3.5);
}

}  // namespace
}  // namespace roadbalance

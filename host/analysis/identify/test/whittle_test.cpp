// Spectra of a car whose road is known exactly, or drawn from it.
#include "host/analysis/identify/whittle.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kRate_hz = 500.0;
const Geometry kGeometry{{1.25, 1.25, -1.45, -1.45}, {0.74, -0.74, 0.74, -0.74}};

ParameterVector car() {
  ParameterVector p = ParameterVector::Zero();
  p.head<kTyreDamper>() << 1300, 480, 2200, 34, 34, 32, 32, 22000, 21000, 24000, 25000, 1500, 1400, 1600,
      1700, 12000, 5000, 215000, 205000, 210000, 220000;
  return p;
}

/// Roads of left/right correlation 0.3, the rear ones following the front ones with coherence 0.9
/// (amplitude), the right side rougher than the left.
Eigen::Matrix4d road_level() {
  Eigen::Matrix2d sides;
  sides << 1.0, 0.3, 0.3, 1.0;
  Eigen::Matrix4d level;
  level << sides, 0.9 * sides, 0.9 * sides, sides;
  const Eigen::Vector4d rough(1.0, 1.5, 1.0, 1.5);
  return 1e-6 * rough.asDiagonal() * level * rough.asDiagonal();
}

/// Moments with `segments` independent segments in each bin: their expectation, or drawn with `random`.
WhittleMoments spectra(const ParameterVector& parameters, double speed_m_s, double exponent, double segments,
                       std::mt19937_64* random = nullptr) {
  const LinearModel model = linear_model(kGeometry, parameters);
  WhittleMoments moments;
  moments.frequency_hz = Eigen::ArrayXd::LinSpaced(149, 3.0, 40.0);
  moments.segments = segments;
  const double delay_s = (kGeometry.x_m[0] - kGeometry.x_m[2]) / speed_m_s;
  moments.delay_seconds = segments * delay_s;
  moments.count.setConstant(149, segments);
  std::normal_distribution<double> axis(0.0, std::sqrt(0.5));
  const Eigen::Matrix4d root = road_level().llt().matrixL();
  for (Eigen::Index k = 0; k < moments.count.size(); ++k) {
    const double om = moments.omega(k);
    const double corner = kTurn * 4.0 * speed_m_s;
    const double phi = std::pow(om, -exponent) / (1.0 + om * om / (corner * corner));
    const Eigen::Matrix<Complex, kCoordinates, kCoordinates> D =
        model.Q.cast<Complex>() + kJ * om * model.P.cast<Complex>() - (om * om * model.M).cast<Complex>();
    const Complex later = std::polar(1.0, -om * delay_s);
    const Eigen::Matrix<Complex, kCoordinates, kWheels> from_road =
        -om * om * D.partialPivLu().solve(model.S.cast<Complex>() + kJ * om * model.Sd.cast<Complex>()) *
        Eigen::Vector4cd(1.0, 1.0, later, later).asDiagonal() * (std::sqrt(phi) * root).cast<Complex>();
    Eigen::Matrix4cd white = segments * Eigen::Matrix4cd::Identity();
    if (random != nullptr) {
      white.setZero();
      for (int n = 0; n < static_cast<int>(segments); ++n) {
        const Eigen::Vector4cd draw =
            Eigen::Vector4cd::NullaryExpr([&] { return Complex(axis(*random), axis(*random)); });
        white += draw * draw.adjoint();
      }
    }
    moments.same.emplace_back(from_road * white * from_road.adjoint());
    moments.delayed.emplace_back(later * moments.same.back());
  }
  return moments;
}

std::optional<WhittleTyres> solve(const std::vector<WhittleMoments>& speeds, const ParameterVector& begin) {
  std::vector<const WhittleMoments*> pointers;
  for (const auto& moments : speeds) pointers.push_back(&moments);
  return whittle_tyres(pointers, kGeometry, begin, std::bitset<kWheels>().set());
}

ParameterVector begin() {
  ParameterVector p = car();
  p.segment<kWheels>(kTyre) = p.segment<kWheels>(kTyre).cwiseProduct(Eigen::Vector4d(1.1, 0.9, 0.85, 1.15));
  return p;
}

// No bias, although rear wheels roll over the front wheels' road and no side is as rough as the other.
TEST(WhittleTyres, ReturnsTheCarFromExactSpectraOfCoherentRoads) {
  const auto x = solve({spectra(car(), 31.0, 1.8, 10), spectra(car(), 36.0, 1.8, 10)}, begin());
  ASSERT_TRUE(x.has_value());
  for (int i = 0; i < kWheels; ++i) EXPECT_NEAR(x->tyre_n_m(i) / car()(kTyre + i), 1.0, 1e-5) << i;
  EXPECT_NEAR(x->exponent, 1.8, 1e-5);
}

TEST(WhittleTyres, TakesAKnownTyreDamperIntoAccount) {
  ParameterVector damped = car(), from = begin();
  damped.segment<kWheels>(kTyreDamper).setConstant(150.0);
  from.segment<kWheels>(kTyreDamper).setConstant(150.0);
  const auto x = solve({spectra(damped, 31.0, 2.0, 10)}, from);
  ASSERT_TRUE(x.has_value());
  for (int i = 0; i < kWheels; ++i) EXPECT_NEAR(x->tyre_n_m(i) / car()(kTyre + i), 1.0, 1e-5) << i;
}

TEST(WhittleTyres, ScattersAsItsCovarianceSays) {
  std::mt19937_64 random(5);
  const int runs = 60;
  double sum = 0.0;
  for (int run = 0; run < runs; ++run) {
    const auto x =
        solve({spectra(car(), 31.0, 2.0, 10, &random), spectra(car(), 36.0, 2.0, 10, &random)}, car());
    ASSERT_TRUE(x.has_value());
    const Eigen::Vector4d error = x->tyre_n_m - car().segment<kWheels>(kTyre);
    sum += error.dot(x->covariance.ldlt().solve(error));
  }
  // Chi-squared of 4 degrees of freedom: mean 4, variance 8.
  EXPECT_NEAR(sum / runs, 4.0, 4.0 * std::sqrt(8.0 / runs));
}

TEST(WhittleTyres, KeepsTyresThatAreKnown) {
  const std::vector<WhittleMoments> speeds{spectra(car(), 31.0, 2.0, 10)};
  const WhittleMoments* pointer = speeds.data();
  ParameterVector from = car();
  from(kTyre) *= 0.9;
  const auto x = whittle_tyres({&pointer, 1}, kGeometry, from, std::bitset<kWheels>(1));
  ASSERT_TRUE(x.has_value());
  EXPECT_NEAR(x->tyre_n_m(0) / car()(kTyre), 1.0, 1e-5);
  EXPECT_EQ(x->tyre_n_m(2), car()(kTyre + 2));
  EXPECT_EQ(x->covariance(2, 2), 0.0);
}

TEST(WhittleTyres, SaysNothingWithoutSegmentsAndFarFromItsBeginning) {
  EXPECT_FALSE(solve({WhittleMoments{}}, car()).has_value());
  ParameterVector far = car();
  far(kTyre) *= 2.0;
  EXPECT_FALSE(solve({spectra(car(), 31.0, 2.0, 10)}, far).has_value());
}

SignalMatrix noise(Eigen::Index samples, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> white;
  return SignalMatrix::NullaryExpr(kSignals, samples, [&] { return white(random); });
}

TEST(WhittleMoments, CountAsManyIndependentBinsAsTheScatterOfTheirMeanShows) {
  WhittleGatherer gather(kGeometry, kRate_hz);
  double sum = 0.0, squares = 0.0, variance = 0.0;
  const int runs = 150;
  for (int run = 0; run < runs; ++run) {
    const WhittleMoments m =
        gather.moments(noise(5000, static_cast<std::uint64_t>(run)), Eigen::Vector4d::Zero(), 30.0);
    double power = 0.0;
    for (const auto& bin : m.same) power += bin(0, 0).real();
    const double mean = power / m.count.sum();
    sum += mean;
    squares += mean * mean;
    variance = 1.0 / m.count.sum();  // of the mean's relative error
  }
  const double mean = sum / runs;
  // White noise of unit variance through a Hann window of 2000 samples: 3/8 of them.
  EXPECT_NEAR(mean / 750.0, 1.0, 4.0 * std::sqrt(variance / runs));
  const double scatter = (squares / runs - mean * mean) / (mean * mean);
  EXPECT_NEAR(scatter / variance, 1.0, 4.0 * std::sqrt(2.0 / runs));
}

TEST(WhittleMoments, AddLikeOneLongDrive) {
  WhittleGatherer gather(kGeometry, kRate_hz);
  const SignalMatrix signals = noise(8000, 3);
  const Eigen::Vector4d omega(100.0, 101.0, 102.0, 103.0);
  const WhittleMoments first = gather.moments(signals.leftCols(3000), omega, 30.0);
  const WhittleMoments second = gather.moments(signals.rightCols(5000), omega, 30.0);
  WhittleMoments sum;
  sum += first;
  sum += WhittleMoments{};
  sum += second;
  EXPECT_DOUBLE_EQ(sum.segments, first.segments + second.segments);
  EXPECT_TRUE(sum.count.isApprox(first.count + second.count));
  for (std::size_t k = 0; k < sum.same.size(); ++k) {
    EXPECT_TRUE(sum.same[k].isApprox(first.same[k] + second.same[k]) ||
                sum.count(static_cast<Eigen::Index>(k)) == 0.0);
    EXPECT_TRUE(sum.delayed[k].isApprox(first.delayed[k] + second.delayed[k]) ||
                sum.count(static_cast<Eigen::Index>(k)) == 0.0);
  }
}

TEST(WhittleMoments, LeaveOutTheBinsOfALineOfEachOrderInWhichForcesVary) {
  WhittleGatherer gather(kGeometry, kRate_hz);
  const SignalMatrix quiet = noise(5000, 4);
  constexpr std::array kLines_hz{12.03, 24.06, 36.09};
  SignalMatrix loud = quiet;
  for (const double line_hz : kLines_hz)
    for (Eigen::Index k = 0; k < loud.cols(); ++k)
      loud.col(k).head<kCoordinates>().array() +=
          2.0 * std::cos(kTurn * line_hz * static_cast<double>(k) / kRate_hz);
  const Eigen::Vector4d omega(kTurn * kLines_hz[0], 0.0, 0.0, 0.0);
  const WhittleMoments without = gather.moments(quiet, omega, 30.0);
  const WhittleMoments with = gather.moments(loud, omega, 30.0);
  const double step_hz = with.frequency_hz(1) - with.frequency_hz(0);
  for (Eigen::Index k = 0; k < with.count.size(); ++k) {
    double away = std::numeric_limits<double>::infinity();
    for (const double line_hz : kLines_hz)
      away = std::min(away, std::abs(with.omega(k) / kTurn - line_hz) / step_hz);
    EXPECT_EQ(with.count(k) > 0.0, away > 2.6) << away;
    if (with.count(k) == 0.0) continue;
    // The line is 2000 times a bin of the noise; beyond 2.6 bins the Hann window leaves less than -32 dB.
    const auto b = static_cast<std::size_t>(k);
    const double line = std::norm(2.0 * 2000.0 / 4.0) * 6.3e-4;
    const double bound = with.count(k) * (line + 2.0 * std::sqrt(line * 6.0 * 750.0));
    EXPECT_LT(std::abs(with.same[b](0, 0) - without.same[b](0, 0)), bound) << away;
  }
}

}  // namespace
}  // namespace roadbalance

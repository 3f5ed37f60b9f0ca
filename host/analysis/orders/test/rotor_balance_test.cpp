#include "host/analysis/orders/rotor_balance.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <vector>

#include "host/analysis/orders/test/synthetic_rotor.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;
constexpr double kDegree = pi / 180.0;
Complex at(double length, double degrees) {
  return std::polar(length, degrees * kDegree);
}

/// How three channels answer to grams in two planes, and to nothing.
const std::array<Complex, 3> kBare{at(1.2, 30), at(0.8, 200), at(0.5, -60)};
const std::array<std::array<Complex, 2>, 3> kInfluence{
    {{at(0.05, 10), at(0.02, 100)}, {at(0.01, -40), at(0.06, 20)}, {at(0.02, 60), at(0.02, -150)}}};

std::array<Complex, 3> answer(Complex front, Complex back) {
  std::array<Complex, 3> all;
  for (std::size_t k = 0; k < 3; ++k) all[k] = kBare[k] + kInfluence[k][0] * front + kInfluence[k][1] * back;
  return all;
}

/// Best effect of weights in both planes over three channels, in a computation of its own.
struct LeastSquares {
  Eigen::Vector2cd weight_g;
  double left, before;  ///< m/s^2, root of the sum of squares
};
LeastSquares least_squares() {
  Eigen::Matrix<Complex, 3, 2> influence;
  Eigen::Vector3cd bare;
  for (Eigen::Index k = 0; k < 3; ++k) {
    bare(k) = kBare[static_cast<std::size_t>(k)];
    for (Eigen::Index p = 0; p < 2; ++p)
      influence(k, p) = kInfluence[static_cast<std::size_t>(k)][static_cast<std::size_t>(p)];
  }
  const Eigen::Vector2cd best = -(influence.adjoint() * influence).inverse() * influence.adjoint() * bare;
  return {best, (bare + influence * best).norm(), bare.norm()};
}

class BalanceRotor : public testing::Test {
 protected:
  /// A drive with these weights; each begins with the wheels anywhere, and the shaft fixed to them by its
  /// gears.  `datum_rad` is how much further than it stands the wheel's angle is given.
  void run(double ratio, Complex front, Complex back, double datum_rad = 0.0) {
    vehicle_ = test::rotor_vehicle(ratio, {2});
    const double begin = 7.7 * static_cast<double>(orders_.size());
    const auto wheel = [=](double t) { return 2 * pi * 12.0 * t + begin; };
    const auto tooth = std::round(begin / (2 * pi)) * 3.0 * 2 * pi;  // turns the wheel made meanwhile
    const auto counted = [=](double t) { return wheel(t) + datum_rad; };
    const test::SyntheticDrive drive{.left_rad = counted,
                                     .right_rad = counted,
                                     .shaft_rad = [=](double t) { return ratio * (wheel(t) + tooth); },
                                     .vector = answer(front, back),
                                     .noise = 0.2,
                                     .seconds = 30.0,
                                     .seed = 1 + orders_.size()};
    const Rotor rotor = rotor_of(vehicle_, vehicle_.rotor[0]);
    orders_.push_back(std::make_unique<RotorOrders>(vehicle_, rotor, 0, std::vector<std::size_t>{0, 1},
                                                    std::vector<double>{1.0}));
    orders_.push_back(std::make_unique<RotorOrders>(vehicle_, rotor, 1, std::vector<std::size_t>{0},
                                                    std::vector<double>{1.0}));
    const auto last = orders_.end();
    drive.seal_into([&](const SealedBlock& block) {
      (*(last - 1))->consume(block);
      (*(last - 2))->consume(block);
    });
    runs_.push_back({.weight_g = {front, back},
                     .orders = {(last - 2)->get(), (last - 1)->get()},
                     .datum_rad = ratio * datum_rad});
  }
  double left_of(const RotorBalance& found) const {
    double square = 0.0;
    for (const Complex& vector : answer(std::polar(found.plane[0].mass_g, found.plane[0].angle_rad),
                                        std::polar(found.plane[1].mass_g, found.plane[1].angle_rad)))
      square += std::norm(vector);
    return std::sqrt(square);
  }
  VehicleConfig vehicle_;
  std::vector<std::unique_ptr<RotorOrders>> orders_;
  std::vector<WeightedRun> runs_;
};

TEST_F(BalanceRotor, FindsWeightsForBothPlanesWhereTheRatioIsWhole) {
  run(4.0, 0.0, 0.0);
  run(4.0, at(20, 0), 0.0);
  run(4.0, 0.0, at(20, 90));
  const RotorBalance found = balance_rotor(vehicle_.rotor[0], runs_);
  ASSERT_EQ(found.refusal, "");
  EXPECT_FALSE(found.by_amplitude);
  EXPECT_EQ(found.observations, 3);
  const auto [best, least, all] = least_squares();
  EXPECT_LT(left_of(found), least + 0.02);
  for (std::size_t p = 0; p < 2; ++p) {
    const Complex weight = std::polar(found.plane[p].mass_g, found.plane[p].angle_rad);
    EXPECT_LT(std::abs(weight - best(static_cast<Eigen::Index>(p))), 4.0 * found.plane[p].mass_sigma_g);
    EXPECT_LT(found.plane[p].mass_sigma_g, 1.0);
  }
  EXPECT_NEAR(found.rms_before, all / std::sqrt(3.0), 0.02);
  EXPECT_NEAR(found.rms_after, least / std::sqrt(3.0), 0.02);
}

TEST_F(BalanceRotor, RefusesPhasesOfDrivesThatCannotBeComparedAndSaysWhatHelps) {
  for (int k = 0; k < 3; ++k) run(3.5, k == 1 ? at(20, 0) : 0.0, k == 2 ? at(20, 90) : 0.0);
  const RotorBalance found = balance_rotor(vehicle_.rotor[0], runs_);
  EXPECT_NE(found.refusal.find("phases cannot be compared"), std::string::npos) << found.refusal;
  EXPECT_NE(found.refusal.find("three or more with the same trial weight"), std::string::npos)
      << found.refusal;
  EXPECT_TRUE(found.plane.empty());
}

TEST_F(BalanceRotor, FindsTheWeightOfOnePlaneFromFourDrivesWithoutPhase) {
  run(3.5, 0.0, 0.0);
  for (const double degrees : {0.0, 120.0, 240.0}) run(3.5, at(20, degrees), 0.0);
  const RotorBalance found = balance_rotor(vehicle_.rotor[0], runs_);
  ASSERT_EQ(found.refusal, "");
  EXPECT_TRUE(found.by_amplitude);
  const Complex expected = -kBare[0] / kInfluence[0][0];  // the channel on which this plane does most
  EXPECT_NEAR(found.plane[0].mass_g, std::abs(expected), 4.0 * found.plane[0].mass_sigma_g);
  EXPECT_NEAR(std::remainder(found.plane[0].angle_rad - std::arg(expected), 2 * pi), 0.0,
              4.0 * found.plane[0].angle_sigma_rad);
  EXPECT_LT(found.plane[0].mass_sigma_g, 2.0);
  EXPECT_EQ(found.plane[1].mass_g, 0.0);
  // 12 turns a second of the wheel are 22.6 m/s.
  EXPECT_EQ(found.observation, "rear.a at 22.0 .. 24.0 m/s");
}

TEST_F(BalanceRotor, TurnsPhasesBackToOneDatum) {
  constexpr double kDatum_rad = 0.7;  // set by rb datum between the first drive and the others
  run(4.0, 0.0, 0.0);
  run(4.0, at(20, 0), 0.0, kDatum_rad);
  run(4.0, 0.0, at(20, 90), kDatum_rad);
  const RotorBalance found = balance_rotor(vehicle_.rotor[0], runs_);
  ASSERT_EQ(found.refusal, "");
  const double least = least_squares().left;
  EXPECT_LT(left_of(found), least + 0.02);
  for (WeightedRun& one : runs_) one.datum_rad = 0.0;
  EXPECT_GT(left_of(balance_rotor(vehicle_.rotor[0], runs_)), 1.5 * least) << "what it is without";
}

TEST_F(BalanceRotor, IsNoSurerThanTheAngleThatPhasesAreCountedFrom) {
  run(4.0, 0.0, 0.0);
  run(4.0, at(20, 0), 0.0);
  run(4.0, 0.0, at(20, 90));
  const RotorBalance sure = balance_rotor(vehicle_.rotor[0], runs_);
  for (WeightedRun& one : runs_) one.phase_sigma_rad = 0.1;
  const RotorBalance unsure = balance_rotor(vehicle_.rotor[0], runs_);
  ASSERT_EQ(unsure.refusal, "");
  for (std::size_t p = 0; p < 2; ++p) {
    EXPECT_NEAR(unsure.plane[p].mass_g, sure.plane[p].mass_g, 1e-9);
    EXPECT_GT(unsure.plane[p].mass_sigma_g, 5.0 * sure.plane[p].mass_sigma_g);
  }
}

TEST_F(BalanceRotor, NeedsThreePlacesOfTheTrialWeightAndSaysWhichItHad) {
  run(3.5, 0.0, 0.0);
  for (const double degrees : {0.0, 360.0, 120.0}) run(3.5, at(20, degrees), 0.0);
  const RotorBalance found = balance_rotor(vehicle_.rotor[0], runs_);
  EXPECT_NE(found.refusal.find("at 2 different angles of its plane only"), std::string::npos)
      << found.refusal;
}

TEST_F(BalanceRotor, NamesWhatIsMissing) {
  run(4.0, 0.0, 0.0);
  run(4.0, at(20, 0), 0.0);
  EXPECT_NE(balance_rotor(vehicle_.rotor[0], runs_).refusal.find("a trial weight in each plane"),
            std::string::npos);
  RotorConfig planeless = vehicle_.rotor[0];
  planeless.plane.clear();
  EXPECT_NE(balance_rotor(planeless, runs_).refusal.find("no [[rotor.plane]]"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance

#include "host/orders/rotor_balance.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <vector>

#include "host/orders/test/synthetic_rotor.hpp"

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

class BalanceRotor : public testing::Test {
 protected:
  /// A drive with these weights; each begins with the wheels anywhere, and the shaft fixed to them by its
  /// gears.
  void run(double ratio, Complex front, Complex back) {
    vehicle_ = test::rotor_vehicle(ratio, {2});
    const double begin = 7.7 * static_cast<double>(orders_.size());
    const auto wheel = [=](double t) { return 2 * pi * 12.0 * t + begin; };
    const auto tooth = std::round(begin / (2 * pi)) * 3.0 * 2 * pi;  // turns the wheel made meanwhile
    const test::SyntheticDrive drive{.left_rad = wheel,
                                     .right_rad = wheel,
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
    runs_.push_back({{front, back}, {(last - 2)->get(), (last - 1)->get()}});
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
  // Least squares over three channels in a computation of its own leave this much of 1.53.
  Eigen::Matrix<Complex, 3, 2> influence;
  Eigen::Vector3cd bare;
  for (Eigen::Index k = 0; k < 3; ++k) {
    bare(k) = kBare[static_cast<std::size_t>(k)];
    for (Eigen::Index p = 0; p < 2; ++p)
      influence(k, p) = kInfluence[static_cast<std::size_t>(k)][static_cast<std::size_t>(p)];
  }
  const Eigen::Vector2cd best = -(influence.adjoint() * influence).inverse() * influence.adjoint() * bare;
  const double least = (bare + influence * best).norm();
  EXPECT_LT(left_of(found), least + 0.02);
  for (std::size_t p = 0; p < 2; ++p) {
    const Complex weight = std::polar(found.plane[p].mass_g, found.plane[p].angle_rad);
    EXPECT_LT(std::abs(weight - best(static_cast<Eigen::Index>(p))), 4.0 * found.plane[p].mass_sigma_g);
    EXPECT_LT(found.plane[p].mass_sigma_g, 1.0);
  }
  EXPECT_NEAR(found.rms_before, bare.norm() / std::sqrt(3.0), 0.02);
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

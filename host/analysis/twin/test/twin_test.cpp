#include "host/analysis/twin/twin.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "common/test/no_allocation.hpp"
#include "common/test/source.hpp"
#include "host/analysis/twin/test/known_drive.hpp"

namespace roadbalance {
namespace {

using test::KnownDrive;
using test::Line;

constexpr std::array<const char*, kWheels> kCarrier{"fl_carrier_z", "fr_carrier_z", "rl_carrier_z",
                                                    "rr_carrier_z"};

const VehicleConfig& vehicle() {
  static const VehicleConfig vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  return vehicle;
}
const TwinChannels& channels() {
  static const TwinChannels channels = TwinChannels::of(vehicle());
  return channels;
}
Eigen::Index channel(const std::string& name) {
  for (std::size_t c = 0; c < channels().channel.size(); ++c) {
    const TwinChannels::One& one = channels().channel[c];
    if (vehicle()
            .node[static_cast<std::size_t>(one.node)]
            .channel[static_cast<std::size_t>(one.channel)]
            .name == name)
      return static_cast<Eigen::Index>(c);
  }
  throw std::invalid_argument(name);
}
TwinCar car() {
  TwinCar car = TwinCar::nominal(vehicle());
  car.geometry = test::kReferenceGeometry;
  car.parameters = test::reference_car();
  car.unbalance_kg_m = test::kReferenceUnbalance;
  return car;
}

/// Root mean squares over 4 s of a drive, after all has settled to 1e-9.
struct Comparison {
  Eigen::ArrayXd measured, residual;
  Eigen::ArrayXd share() const { return residual / measured; }
};
using Alter = std::function<void(SensorSample&)>;
Comparison compare(
    const KnownDrive& drive, const TwinCar& car, const Alter& alter = [](SensorSample&) {}) {
  Twin twin(channels(), car, KnownDrive::kRate_hz);
  const auto n = static_cast<Eigen::Index>(channels().channel.size());
  Comparison sums{Eigen::ArrayXd::Zero(n), Eigen::ArrayXd::Zero(n)};
  const int begin = Twin::kBehind + static_cast<int>((3.0 * twin.settling_s() + 1.0) * KnownDrive::kRate_hz);
  for (int k = 0; k < begin + 2000; ++k) {
    SensorSample sample = drive.sample(channels(), k);
    alter(sample);
    const TwinSample* const output = twin.consume(sample);
    if (k < begin) continue;
    for (const TwinState state : output->state) EXPECT_EQ(state, TwinState::kPredicted);
    sums.measured += output->measured.array().square();
    sums.residual += (output->measured - output->predicted).array().square();
  }
  return {(sums.measured / 2000.0).sqrt(), (sums.residual / 2000.0).sqrt()};
}

/// Root mean square of what sampling alone does to a wheel's prediction, at most: of each line the error of
/// MotionFilter (see its test), of what is dynamic, and 1e-4 of the fractional delay.
double bound(const KnownDrive& drive, int axle, int side) {
  const MotionEquation motion =
      axle_motion(linear_model(test::kReferenceGeometry, test::reference_car()), axle);
  const Eigen::MatrixXcd straight = (motion.M.inverse() * motion.B2).cast<test::Complex>();
  double sum = 0.0;
  for (const Line& line : drive.line) {
    const double theta = line.omega / KnownDrive::kRate_hz;
    const double error =
        std::pow(theta, 4) / 90.0 + 2.0 * std::pow(theta / (2.0 * std::numbers::pi - theta), 3);
    const Eigen::VectorXcd through = straight * test::axle_inputs(line, axle, KnownDrive::delay_s());
    const double z = std::abs(line.z(kBodyCoordinates + 2 * axle + side));
    const double direct = std::abs(through(kAxleWheels + side));
    sum += (1.1 * error + 1e-4) * (z + direct) / std::numbers::sqrt2;
  }
  return sum;
}

TEST(Twin, ExplainsALinearCarUpToWhatSamplingDoes) {
  const KnownDrive drive(test::reference_car());
  const Comparison found = compare(drive, car());
  for (int w = 0; w < kWheels; ++w) {
    const double most = bound(drive, w / 2, w % 2);
    EXPECT_LT(found.residual(channel(kCarrier[static_cast<std::size_t>(w)])), most)
        << kCarrier[static_cast<std::size_t>(w)];
    EXPECT_LT(most,
              0.01 * found.measured(channel(kCarrier[static_cast<std::size_t>(w)])));  // and that is little
  }
  for (const char* strut : {"fl_strut_z", "fr_strut_z", "rl_strut_z", "rr_strut_z"})
    EXPECT_LT(found.share()(channel(strut)), 1e-3) << strut;
}

TEST(Twin, ASensorOnTheBodyThatIsWrongShowsInItselfAlone) {
  const KnownDrive drive(test::reference_car());
  const Comparison right = compare(drive, car());
  const Eigen::Index wrong = channel("rl_strut_z");
  const Comparison found =
      compare(drive, car(), [wrong](SensorSample& sample) { sample.values(wrong) *= -1.0; });
  for (Eigen::Index c = 0; c < found.residual.size(); ++c)
    if (c == wrong)
      EXPECT_NEAR(found.share()(c), 2.0, 0.01);
    else
      EXPECT_EQ(found.residual(c), right.residual(c)) << c;
}

TEST(Twin, AWheelsSensorThatShowsTooMuchShowsOnItsSideOfTheCar) {
  const KnownDrive drive(test::reference_car());
  const Eigen::Index wrong = channel("fl_carrier_z");
  const Comparison found =
      compare(drive, car(), [wrong](SensorSample& sample) { sample.values(wrong) *= 1.1; });
  const Eigen::ArrayXd share = found.share();
  // It shows 1.1 of what the rear wheel's road predicts: a residual of 0.1 / 1.1 of what it shows.  The rear
  // wheel gets a road that is off by what of it this wheel's own motion showed.
  EXPECT_NEAR(share(wrong), 0.1 / 1.1, 0.02);
  EXPECT_GT(share(channel("rl_carrier_z")), 0.05);
  EXPECT_GT(share(channel("fl_strut_z")), 0.05);
  for (const char* other : {"fr_carrier_z", "rr_carrier_z"}) EXPECT_LT(share(channel(other)), 0.02) << other;
}

/// In closed form: root mean square of what the equations of `car()` leave of a drive of another car.
double expected_residual(const KnownDrive& drive, int axle, int side) {
  const MotionEquation motion =
      axle_motion(linear_model(test::kReferenceGeometry, test::reference_car()), axle);
  double sum = 0.0;
  for (const Line& line : drive.line) {
    const Eigen::VectorXcd all =
        motion.response(line.omega) * test::axle_inputs(line, axle, KnownDrive::delay_s());
    sum += 0.5 * std::norm(all(kAxleWheels + side) - line.z(kBodyCoordinates + 2 * axle + side));
  }
  return std::sqrt(sum);
}

TEST(Twin, ADamperThatHasLostAThirdShowsOnItsSideOfTheCar) {
  ParameterVector worn = test::reference_car();
  worn(kDamper) *= 0.7;
  const KnownDrive drive(worn);
  const Comparison found = compare(drive, car());
  const Eigen::ArrayXd share = found.share();
  for (int w = 0; w < kWheels; ++w)
    EXPECT_NEAR(found.residual(channel(kCarrier[static_cast<std::size_t>(w)])),
                expected_residual(drive, w / 2, w % 2), bound(drive, w / 2, w % 2))
        << kCarrier[static_cast<std::size_t>(w)];
  const double others = std::max(share(channel("fr_carrier_z")), share(channel("rr_carrier_z")));
  EXPECT_LT(others, 0.03);
  for (const char* shows : {"fl_carrier_z", "rl_carrier_z", "fl_strut_z"})
    EXPECT_GT(share(channel(shows)), 3.0 * others) << shows;
}

TEST(Twin, TellsNothingOfWheelsIfNobodyKnowsTheSpeed) {
  const KnownDrive drive(test::reference_car());
  Twin twin(channels(), car(), KnownDrive::kRate_hz);
  const TwinSample* output = nullptr;
  for (int k = 0; k < 5000; ++k) {
    SensorSample sample = drive.sample(channels(), k);
    sample.values.tail<2 * kWheels>().setZero();
    output = twin.consume(sample);
  }
  EXPECT_EQ(output->state[static_cast<std::size_t>(TwinPart::kBody)], TwinState::kPredicted);
  EXPECT_EQ(output->state[static_cast<std::size_t>(TwinPart::kFront)], TwinState::kNoSpeed);
  EXPECT_EQ(output->state[static_cast<std::size_t>(TwinPart::kRear)], TwinState::kNoSpeed);
}

TEST(Twin, BeginsAnewAfterAHole) {
  const KnownDrive drive(test::reference_car());
  Twin twin(channels(), car(), KnownDrive::kRate_hz);
  const int settled = static_cast<int>((twin.settling_s() + 1.0) * KnownDrive::kRate_hz) + Twin::kBehind;
  const TwinSample* output = nullptr;
  for (int k = 0; k < settled; ++k) output = twin.consume(drive.sample(channels(), k));
  for (const TwinState state : output->state) EXPECT_EQ(state, TwinState::kPredicted);
  SensorSample after = drive.sample(channels(), settled + 300);
  after.restart = true;
  EXPECT_EQ(twin.consume(after), nullptr);
  for (int k = 1; k <= Twin::kBehind + 10; ++k)
    output = twin.consume(drive.sample(channels(), settled + 300 + k));
  for (const TwinState state : output->state) EXPECT_EQ(state, TwinState::kSettling);
}

TEST(Twin, ACarThatIsKnownABitBetterNeedNotSettleAgain) {
  const KnownDrive drive(test::reference_car());
  Twin twin(channels(), car(), KnownDrive::kRate_hz);
  const int settled = static_cast<int>((twin.settling_s() + 1.0) * KnownDrive::kRate_hz) + Twin::kBehind;
  for (int k = 0; k < settled; ++k) twin.consume(drive.sample(channels(), k));
  TwinCar better = car();
  better.parameters(kTyre) *= 1.01;
  twin.change(better);
  for (const TwinState state : twin.consume(drive.sample(channels(), settled))->state)
    EXPECT_EQ(state, TwinState::kPredicted);
  better.parameters(kTyre) *= 1.05;
  twin.change(better);
  for (const TwinState state : twin.consume(drive.sample(channels(), settled + 1))->state)
    EXPECT_EQ(state, TwinState::kSettling);
}

TEST(Twin, AStabiliserThatVehicleTomlDoesNotHaveMakesItAnotherCar) {
  TwinCar without = car(), with = car();
  without.parameters.segment<2>(kStabiliser).setZero();
  with.parameters.segment<2>(kStabiliser).setZero();
  const double spring = 0.5 * (car().parameters(kSpring + 2) + car().parameters(kSpring + 3));
  with.parameters(kStabiliser + 1) = 0.25 * spring;  // of the rear
  EXPECT_NEAR(greatest_difference(with, without), 0.25, 1e-12);
  EXPECT_NEAR(greatest_difference(without, with), 0.25, 1e-12);
  EXPECT_EQ(greatest_difference(without, without), 0.0);

  const KnownDrive drive(test::reference_car());
  Twin twin(channels(), without, KnownDrive::kRate_hz);
  const int settled = static_cast<int>((twin.settling_s() + 1.0) * KnownDrive::kRate_hz) + Twin::kBehind;
  for (int k = 0; k < settled; ++k) twin.consume(drive.sample(channels(), k));
  twin.change(with);
  for (const TwinState state : twin.consume(drive.sample(channels(), settled))->state)
    EXPECT_EQ(state, TwinState::kSettling);
}

TEST(Twin, ACarWhoseMotionDoesNotDecayIsRefusedAndChangesNothing) {
  const KnownDrive drive(test::reference_car());
  Twin twin(channels(), car(), KnownDrive::kRate_hz), untouched(channels(), car(), KnownDrive::kRate_hz);
  TwinCar impossible = car();
  impossible.parameters.segment<2>(kStabiliser).setConstant(-1e6);
  for (int k = 0; k < 6000; ++k) {
    if (k == 5000) {
      EXPECT_THROW(twin.change(impossible), std::invalid_argument);
    }
    const SensorSample sample = drive.sample(channels(), k);
    const TwinSample* const output = twin.consume(sample);
    const TwinSample* const expected = untouched.consume(sample);
    ASSERT_EQ(output == nullptr, expected == nullptr);
    if (!output) continue;
    ASSERT_EQ(output->predicted, expected->predicted);
    ASSERT_EQ(output->state, expected->state);
  }
  EXPECT_EQ(twin.car().parameters, car().parameters);
}

TEST(TwinCar, AnEstimateThatNoCarCanBeCountsAsNone) {
  const TwinCar nominal = TwinCar::nominal(vehicle());
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  Identification good;
  good.state = Unknown::kNone;
  good.spring_n_m.fill(31e3);
  good.damper_n_s_m.fill(2.1e3);
  good.stabiliser_n_m.fill(-40.0);  // none, and a little noise
  good.tyre_n_m.fill(210e3);
  EXPECT_TRUE(TwinCar::estimated(vehicle(), good, {}).identified);
  for (const double bad : {nan, inf, -inf}) {
    Identification one = good;
    one.stabiliser_n_m[1] = bad;
    const TwinCar car = TwinCar::estimated(vehicle(), one, {});
    EXPECT_FALSE(car.identified) << bad;
    EXPECT_EQ(car.parameters, nominal.parameters) << bad;
  }
  std::array<Balance, kWheels> balance;
  for (int w = 0; w < kWheels; ++w) {
    Balance& one = balance[static_cast<std::size_t>(w)];
    one.wheel = w;
    one.state = Unknown::kNone;
    one.unbalance_g = 20.0;
    one.angle_rad = 1.0;
  }
  balance[1].unbalance_g = nan;
  balance[2].angle_rad = inf;
  balance[3].unbalance_g = -20.0;
  const TwinCar car = TwinCar::estimated(vehicle(), good, balance);
  EXPECT_EQ(car.balance, (std::array{true, false, false, false}));
  EXPECT_NEAR(std::abs(car.unbalance_kg_m[0]), 0.020 * vehicle().wheel[0].weight_radius_m, 1e-12);
  for (std::size_t w = 1; w < kWheels; ++w) EXPECT_EQ(car.unbalance_kg_m[w], 0.0) << w;
}

TEST(Twin, NeverAllocates) {
  const KnownDrive drive(test::reference_car());
  Twin twin(channels(), car(), KnownDrive::kRate_hz);
  std::vector<SensorSample> samples;
  for (int k = 0; k < 5000; ++k) samples.push_back(drive.sample(channels(), k));
  const test::NoAllocation guard;
  for (const SensorSample& sample : samples) twin.consume(sample);
}

}  // namespace
}  // namespace roadbalance

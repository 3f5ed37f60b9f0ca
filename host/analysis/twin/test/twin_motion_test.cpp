// The twin's equations against the whole car's, in closed form at single frequencies.
#include "host/analysis/twin/twin_motion.hpp"

#include <gtest/gtest.h>

#include "host/analysis/twin/test/known_drive.hpp"

namespace roadbalance {
namespace {

using namespace test;  // NOLINT: a test of what is in there

const KnownDrive& drive() {
  static const KnownDrive drive(reference_car(), 90.0);
  return drive;
}
const LinearModel& model() {
  static const LinearModel model = linear_model(kReferenceGeometry, reference_car());
  return model;
}

TEST(BodyMotion, IsWhatTheWheelsMakeTheBodyDo) {
  const MotionEquation body = body_motion(model());
  for (const Line& line : drive().line) {
    const Eigen::Vector3cd expected = line.z.head<3>(), found = body.response(line.omega) * line.z.tail<4>();
    EXPECT_LT((found - expected).norm(), 1e-10 * expected.norm()) << line.omega;
  }
}

TEST(AxleMotion, IsWhatTheOtherAxlesRoadMakesTheWheelsDo) {
  for (const int axle : {0, 1}) {
    const MotionEquation motion = axle_motion(model(), axle);
    for (const Line& line : drive().line) {
      const Eigen::Vector2cd found = motion.response(line.omega).middleRows<2>(kAxleWheels) *
                                     axle_inputs(line, axle, KnownDrive::delay_s());
      const Eigen::Vector2cd expected = line.z.segment<2>(kBodyCoordinates + 2 * axle);
      EXPECT_LT((found - expected).norm(), 1e-9 * expected.norm()) << axle << " at " << line.omega;
    }
  }
}

TEST(AxleMotion, NeedsTheUnbalanceOfBothAxles) {
  const Line& line = drive().line.back();
  const MotionEquation motion = axle_motion(model(), 1);
  for (const int missing : {static_cast<int>(kOtherForceThen), static_cast<int>(kForceNow)}) {
    Eigen::VectorXcd u = axle_inputs(line, 1, KnownDrive::delay_s());
    u.segment<2>(missing).setZero();
    const Eigen::Vector2cd found = motion.response(line.omega).middleRows<2>(kAxleWheels) * u;
    EXPECT_GT((found - line.z.tail<2>()).norm(), 0.01 * line.z.tail<2>().norm());
  }
}

}  // namespace
}  // namespace roadbalance

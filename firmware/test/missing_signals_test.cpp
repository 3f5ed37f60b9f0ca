#include "firmware/missing_signals.hpp"

#include <gtest/gtest.h>

#include "firmware/test/vehicle.hpp"

namespace roadbalance {
namespace {

TEST(MissingSignals, AreNamedWithTheWheelThatNeedsThem) {
  VehicleConfig vehicle = test::one_node_vehicle();
  NodeConfig& node = vehicle.node[0];
  EXPECT_TRUE(missing_signals(vehicle, node).empty());
  vehicle.wheel[1].encoder.steering_ratio = 0.0625;
  ASSERT_EQ(missing_signals(vehicle, node).size(), 1U);
  EXPECT_EQ(missing_signals(vehicle, node)[0].find("front_right: its encoder gains when the car steers"), 0U);
  CanConfig can;
  can.signal = {{"steering", "STEER", "ANGLE", SignalQuantity::kSteeringAngle, ""}};
  node.wiring.can = {can};
  EXPECT_TRUE(missing_signals(vehicle, node).empty());
  vehicle.wheel[0].encoder.counter = "fl_pulses";
  EXPECT_TRUE(missing_signals(vehicle, node).empty());
  vehicle.wheel[0].encoder.zero_mark = false;
  ASSERT_EQ(missing_signals(vehicle, node).size(), 1U);
  EXPECT_NE(missing_signals(vehicle, node)[0].find("there will be no angle"), std::string::npos);
  vehicle.wheel[0].node.clear();
  EXPECT_TRUE(missing_signals(vehicle, node).empty()) << "another node's wheel";
}

}  // namespace
}  // namespace roadbalance

#include "firmware/backends/socketcan/can_link.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "common/config/section.hpp"
#include "firmware/backends/socketcan/can_intake.hpp"
#include "hil_tests/guest/can_player.hpp"
#include "hil_tests/program.hpp"

namespace roadbalance {
namespace {

using test::CanPlayer;
using test::ip;
using test::wait_until;

const std::vector<CanId> kWanted{{0x100, false}};

/// The first of the guest's two SJA1000 controllers on one bus, in a mode.
void set_controller(const std::string& interface, const std::string& mode) {
  ip("link set " + interface + " down");
  ip("link set " + interface + " type can bitrate 500000 listen-only " + mode);
  ip("link set " + interface + " up");
}

std::string refusal(const std::string& interface, CanRole role) {
  try {
    const CanIntake intake(interface, role, kWanted);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CanLink, HoldsARealControllerToItsRole) {
  ASSERT_TRUE(test::has_interface("can0")) << "the guest has no CAN controller";
  set_controller("can0", "off");
  EXPECT_EQ(refusal("can0", CanRole::kSensor), "accepted");
  EXPECT_EQ(
      refusal("can0", CanRole::kVehicle),
      "CAN interface can0 is not listen-only, as role \"vehicle\" demands: it would answer on the car's own "
      "bus; try: ip link set can0 down; ip link set can0 type can listen-only on; ip link set can0 up");
  set_controller("can0", "on");
  EXPECT_EQ(refusal("can0", CanRole::kVehicle), "accepted");
  EXPECT_EQ(
      refusal("can0", CanRole::kSensor),
      "CAN interface can0 is listen-only, but role \"sensor\" demands that it acknowledges frames; try: ip "
      "link set can0 down; ip link set can0 type can listen-only off; ip link set can0 up");
  ip("link set can0 down");
  EXPECT_EQ(refusal("can0", CanRole::kVehicle), "CAN interface can0 is down; try: ip link set can0 up");
  ip("link set can0 type can listen-only off");
}

TEST(CanLink, RefusesWhatIsNoCanInterface) {
  EXPECT_EQ(refusal("can99", CanRole::kVehicle),
            "CAN interface can99: there is none of that name; try: ip link show type can");
  EXPECT_EQ(refusal("lo", CanRole::kVehicle), "CAN interface lo: this is no CAN interface");
  EXPECT_EQ(
      refusal("a-name-that-is-much-too-long", CanRole::kSensor),
      "CAN interface a-name-that-is-much-too-long: there is none of that name; try: ip link show type can");
}

TEST(CanLink, TakesAnInterfaceWithoutControllerInBothRoles) {
  const test::VirtualCan can("vcan8");
  EXPECT_EQ(refusal("vcan8", CanRole::kVehicle), "accepted");
  EXPECT_EQ(refusal("vcan8", CanRole::kSensor), "accepted");
  EXPECT_TRUE(query_can_link("vcan8").value().flexible);
  ip("link set vcan8 down");
  ip("link set vcan8 mtu 16");
  EXPECT_FALSE(query_can_link("vcan8").value().flexible);
}

/// A cable between two interfaces, of which the node listens to one.
class CableTest : public testing::Test {
 protected:
  void SetUp() override { lay(); }
  void TearDown() override {
    if (test::has_interface("vx0")) ip("link del vx0");
  }
  static void lay() {
    ip("link add vx0 type vxcan peer name vx1");
    ip("link set vx0 up");
    ip("link set vx1 up");
  }
  /// Sends until one arrives: how many then wait, and whether the first of them says it follows an absence.
  static bool arrives(CanIntake& intake) {
    CanPlayer player("vx1");
    return wait_until(
        [&] {
          player.send({.id = 0x100, .size = 8});
          return intake.size() > 0;
        },
        10);
  }
  static std::int64_t of(const CanIntake& intake, DeviceCounter counter) {
    return intake.report().of(counter);
  }
};

TEST_F(CableTest, GoesDownAndComesBackTenTimes) {
  CanIntake intake("vx0", CanRole::kVehicle, kWanted);
  ASSERT_TRUE(arrives(intake));
  EXPECT_FALSE(intake[0].after_absence);
  for (int turn = 1; turn <= 10; ++turn) {
    intake.drop(intake.size());
    ip("link set vx0 down");
    ASSERT_TRUE(wait_until([&] { return of(intake, DeviceCounter::kGone) == turn; }, 10));
    EXPECT_LE(node_time_from_ns(to_ns(MachineClock::now())) - intake.complete_until(),
              std::chrono::milliseconds(1));  // nothing to wait for
    ip("link set vx0 up");
    ASSERT_TRUE(wait_until([&] { return of(intake, DeviceCounter::kReturned) == turn; }, 10));
    ASSERT_TRUE(arrives(intake));
    EXPECT_TRUE(intake[0].after_absence);
  }
}

TEST_F(CableTest, IsHeardAgainAfterItWasRemovedAndMadeAnew) {
  CanIntake intake("vx0", CanRole::kVehicle, kWanted);
  ASSERT_TRUE(arrives(intake));
  intake.drop(intake.size());
  ip("link del vx0");
  ASSERT_TRUE(wait_until([&] { return of(intake, DeviceCounter::kGone) == 1; }, 10));
  lay();  // with another index
  ASSERT_TRUE(wait_until([&] { return of(intake, DeviceCounter::kReturned) == 1; }, 10));
  ASSERT_TRUE(arrives(intake));
  EXPECT_TRUE(intake[0].after_absence);
}

TEST(CanIntake, DoesNotListenToAControllerThatCameBackInAnotherRole) {
  ASSERT_TRUE(test::has_interface("can0")) << "the guest has no CAN controller";
  set_controller("can0", "on");
  const CanIntake intake("can0", CanRole::kVehicle, kWanted);
  set_controller("can0", "off");
  ASSERT_TRUE(wait_until([&] { return intake.report().of(DeviceCounter::kGone) == 1; }, 10));
  EXPECT_FALSE(wait_until([&] { return intake.report().of(DeviceCounter::kReturned) > 0; }, 0.5));
  set_controller("can0", "on");
  EXPECT_TRUE(wait_until([&] { return intake.report().of(DeviceCounter::kReturned) == 1; }, 10));
  ip("link set can0 down");
  ip("link set can0 type can listen-only off");
}

}  // namespace
}  // namespace roadbalance

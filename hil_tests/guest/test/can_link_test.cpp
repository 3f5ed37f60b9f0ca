#include "firmware/backends/socketcan/can_link.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

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
    const CanIntake intake(interface, {.role = role}, kWanted, [](const std::string&) {});
  } catch (const CanError& error) {
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
  EXPECT_TRUE(query_can_link("vcan8").value().takes_fd);
  ip("link set vcan8 down");
  ip("link set vcan8 mtu 16");
  ip("link set vcan8 up");
  const auto classic = query_can_link("vcan8");
  EXPECT_FALSE(classic.value().takes_fd);
  EXPECT_EQ(refusal(classic, {.role = CanRole::kVehicle}, "vcan8"), "");
  EXPECT_EQ(
      refusal(classic, {.role = CanRole::kVehicle, .fd = true}, "vcan8"),
      "CAN interface vcan8 carries no CAN FD, but a message wanted of it has more than 8 bytes; try: ip link "
      "set vcan8 down; ip link set vcan8 mtu 72; ip link set vcan8 up");
}

/// A cable between two interfaces, of which the node listens to one.
class CableTest : public testing::Test {
 protected:
  /// Sends until one has arrived, which waits at the front then.
  static bool arrives(CanIntake& intake) {
    CanPlayer player("vx1");
    return wait_until(
        [&] {
          player.send({.id = 0x100, .size = 8});
          return intake.front() != nullptr;
        },
        10);
  }
  /// Waits until it counts so many absences and empties its queue then: frames sent before come until it is
  /// gone.
  static bool is_gone(CanIntake& intake, int times) {
    if (!wait_until([&] { return of(intake, DeviceCounter::kGone) == times; }, 10)) return false;
    while (intake.front()) intake.pop();
    return true;
  }
  static std::int64_t of(const CanIntake& intake, DeviceCounter counter) {
    return intake.report().of(counter);
  }

  std::optional<test::VirtualCan> cable{std::in_place, "vx0", "vx1"};
};

TEST_F(CableTest, GoesDownAndComesBackTenTimes) {
  CanIntake intake("vx0", {.role = CanRole::kVehicle}, kWanted, [](const std::string&) {});
  ASSERT_TRUE(arrives(intake));
  EXPECT_FALSE(intake.front()->after_absence);
  for (int turn = 1; turn <= 10; ++turn) {
    ip("link set vx0 down");
    ASSERT_TRUE(is_gone(intake, turn));
    EXPECT_LE(as_node_time(MachineClock::now()) - intake.complete_until(),
              std::chrono::milliseconds(1));  // nothing to wait for
    ip("link set vx0 up");
    ASSERT_TRUE(wait_until([&] { return of(intake, DeviceCounter::kReturned) == turn; }, 10));
    ASSERT_TRUE(arrives(intake));
    EXPECT_TRUE(intake.front()->after_absence);
  }
}

TEST_F(CableTest, IsHeardAgainAfterItWasRemovedAndMadeAnew) {
  CanIntake intake("vx0", {.role = CanRole::kVehicle}, kWanted, [](const std::string&) {});
  ASSERT_TRUE(arrives(intake));
  cable.reset();
  ASSERT_TRUE(is_gone(intake, 1));
  cable.emplace("vx0", "vx1");  // with another index
  ASSERT_TRUE(wait_until([&] { return of(intake, DeviceCounter::kReturned) == 1; }, 10));
  ASSERT_TRUE(arrives(intake));
  EXPECT_TRUE(intake.front()->after_absence);
}

/// Texts of a thread of the intake.
class Warnings {
 public:
  CanIntake::Warn hear() {
    return [this](const std::string& text) {
      const std::lock_guard lock(mutex_);
      reported_.push_back(text);
    };
  }
  std::vector<std::string> said() const {
    const std::lock_guard lock(mutex_);
    return reported_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> reported_;
};

TEST_F(CableTest, SaysOnceWhyAnInterfaceStaysAway) {
  Warnings warnings;
  CanIntake intake("vx0", {.role = CanRole::kVehicle}, kWanted, warnings.hear());
  ip("link set vx0 down");
  const std::string down = "CAN interface vx0 is down; try: ip link set vx0 up";
  EXPECT_TRUE(wait_until([&] { return !warnings.said().empty(); }, 10));
  EXPECT_FALSE(wait_until([&] { return warnings.said().size() > 1; }, 2.5));
  EXPECT_EQ(warnings.said(), std::vector{down});
  ip("link set vx0 up");
  EXPECT_TRUE(wait_until([&] { return of(intake, DeviceCounter::kReturned) == 1; }, 10));
  ip("link set vx0 down");
  EXPECT_TRUE(wait_until([&] { return warnings.said().size() == 2; }, 10));
  EXPECT_EQ(warnings.said(), (std::vector{down, down}));
}

TEST(CanIntake, DoesNotListenToAControllerThatCameBackInAnotherRole) {
  ASSERT_TRUE(test::has_interface("can0")) << "the guest has no CAN controller";
  set_controller("can0", "on");
  Warnings warnings;
  const CanIntake intake("can0", {.role = CanRole::kVehicle}, kWanted, warnings.hear());
  set_controller("can0", "off");
  ASSERT_TRUE(wait_until([&] { return intake.report().of(DeviceCounter::kGone) == 1; }, 10));
  EXPECT_FALSE(wait_until([&] { return intake.report().of(DeviceCounter::kReturned) > 0; }, 3));
  EXPECT_EQ(
      warnings.said(),
      std::vector<std::string>{
          "CAN interface can0 is not listen-only, as role \"vehicle\" demands: it would answer on the "
          "car's own bus; try: ip link set can0 down; ip link set can0 type can listen-only on; ip link "
          "set can0 up"});
  set_controller("can0", "on");
  EXPECT_TRUE(wait_until([&] { return intake.report().of(DeviceCounter::kReturned) == 1; }, 10));
  ip("link set can0 down");
  ip("link set can0 type can listen-only off");
}

}  // namespace
}  // namespace roadbalance

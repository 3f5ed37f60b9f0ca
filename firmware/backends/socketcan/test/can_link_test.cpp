#include <gtest/gtest.h>

#include "firmware/backends/socketcan/can_link.hpp"

namespace roadbalance {
namespace {

using Kind = CanLink::Kind;

bool suits_in(Kind kind, bool listen_only, CanRole role) {
  return suits({.kind = kind, .up = true, .listen_only = listen_only}, role);
}

TEST(CanRole, WantsAControllerToKeepSilentOnTheCarsBusAndToAcknowledgeOnOurs) {
  EXPECT_TRUE(suits_in(Kind::kController, true, CanRole::kVehicle));
  EXPECT_FALSE(suits_in(Kind::kController, false, CanRole::kVehicle));
  EXPECT_FALSE(suits_in(Kind::kController, true, CanRole::kSensor));
  EXPECT_TRUE(suits_in(Kind::kController, false, CanRole::kSensor));
}

TEST(CanRole, TakesAVirtualInterfaceInBothAndAnotherInNone) {
  for (const CanRole role : {CanRole::kVehicle, CanRole::kSensor}) {
    EXPECT_TRUE(suits_in(Kind::kVirtual, false, role));
    EXPECT_FALSE(suits_in(Kind::kOther, false, role));
    EXPECT_FALSE(suits_in(Kind::kOther, true, role));
  }
}

TEST(CanRole, SaysWhatIsWrongAndHowToMendIt) {
  const auto says = [](const std::optional<CanLink>& link, CanRole role, const std::string& words) {
    return refusal(link, {.role = role}, "can3").find(words) != std::string::npos;
  };
  const CanLink normal{.kind = Kind::kController, .up = true};
  EXPECT_TRUE(says(std::nullopt, CanRole::kVehicle, "can3: there is none of that name"));
  EXPECT_TRUE(says(CanLink{.up = true}, CanRole::kVehicle, "can3: this is no CAN interface"));
  EXPECT_TRUE(says(normal, CanRole::kVehicle, "ip link set can3 type can listen-only on"));
  EXPECT_EQ(refusal(normal, {.role = CanRole::kSensor}, "can3"), "");
  CanLink silent = normal;
  silent.listen_only = true;
  EXPECT_TRUE(says(silent, CanRole::kSensor, "ip link set can3 type can listen-only off"));
  EXPECT_EQ(refusal(silent, {.role = CanRole::kVehicle}, "can3"), "");
  silent.up = false;
  EXPECT_TRUE(says(silent, CanRole::kVehicle, "can3 is down; try: ip link set can3 up"));
}

TEST(CanRole, RefusesAClassicInterfaceForMessagesOfCanFd) {
  CanLink link{.kind = Kind::kController, .up = true};
  const CanNeed fd{.role = CanRole::kSensor, .fd = true};
  EXPECT_EQ(
      refusal(link, fd, "can3"),
      "CAN interface can3 carries no CAN FD, but a message wanted of it has more than 8 bytes; try: ip link "
      "set can3 down; ip link set can3 type can bitrate 500000 dbitrate 2000000 fd on; ip link set can3 up");
  link.takes_fd = true;
  EXPECT_EQ(refusal(link, fd, "can3"), "");
  EXPECT_EQ(refusal(link, {.role = CanRole::kSensor}, "can3"), "") << "it carries classic frames, too";
}

TEST(CanRole, AsksTheRealKernelAboutAnInterfaceThatIsNoCan) {
  const auto loopback = query_can_link("lo");
  ASSERT_TRUE(loopback);
  EXPECT_EQ(loopback->kind, Kind::kOther);
  EXPECT_FALSE(query_can_link("no-such-thing"));
  EXPECT_FALSE(query_can_link("a name longer than any interface has"));
}

}  // namespace
}  // namespace roadbalance

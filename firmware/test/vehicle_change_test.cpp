#include "firmware/vehicle_change.hpp"

#include <gtest/gtest.h>

#include "common/types/text_crc.hpp"

namespace roadbalance {
namespace {

Command configure(const std::string& text, std::int64_t request) {
  return {.node = 1,
          .request = request,
          .incarnation = 1,
          .verb = Verb::kConfigure,
          .vehicle_crc32c = crc32c(text)};
}

VehiclePart part(const std::string& text, std::int32_t number, std::int32_t of) {
  const std::size_t size = (text.size() + static_cast<std::size_t>(of) - 1) / static_cast<std::size_t>(of);
  return {.node = 1,
          .incarnation = 1,
          .vehicle_crc32c = crc32c(text),
          .part = number,
          .parts = of,
          .text = text.substr(static_cast<std::size_t>(number) * size, size)};
}

TEST(VehicleChange, IsWantedOnceEveryPartHasCome) {
  VehicleChange change("old", true);
  const std::string wanted = "another text";
  EXPECT_EQ(change.ask(configure(wanted, 1))->result, CommandError::kVehicleMissing);
  change.take(part(wanted, 2, 3));
  change.take(part(wanted, 0, 3));
  EXPECT_EQ(change.ask(configure(wanted, 1))->result, CommandError::kVehicleMissing);
  change.take(part(wanted, 1, 3));
  EXPECT_FALSE(change.ask(configure(wanted, 1)));
  ASSERT_TRUE(change.wanted());
  EXPECT_EQ(*change.wanted(), wanted);
  EXPECT_FALSE(change.ask(configure(wanted, 1))) << "repeated while it is being made";
  EXPECT_EQ(change.ask(configure("third", 2))->result, CommandError::kMeasuring);
  change.made();
  EXPECT_EQ(change.outcome(1)->result, CommandError::kNone);
  EXPECT_EQ(change.in_force(), crc32c(wanted));
  EXPECT_EQ(change.ask(configure(wanted, 3))->result, CommandError::kNone) << "it is in force already";
}

TEST(VehicleChange, OneThatIsRefusedLeavesWhatWas) {
  VehicleChange change("old", true);
  change.take(part("new", 0, 1));
  EXPECT_FALSE(change.ask(configure("new", 1)));
  change.refused("no such range");
  EXPECT_EQ(change.outcome(1)->result, CommandError::kVehicleRefused);
  EXPECT_EQ(change.outcome(1)->why, "no such range");
  EXPECT_EQ(change.in_force(), crc32c("old"));
  EXPECT_FALSE(change.wanted());
}

TEST(VehicleChange, PartsThatDoNotMakeTheTextTheySayAreNone) {
  VehicleChange change("old", true);
  VehiclePart altered = part("new", 0, 1);
  altered.text = "neu";
  change.take(altered);
  EXPECT_EQ(change.ask(configure("new", 1))->result, CommandError::kVehicleMissing);
}

TEST(VehicleChange, ANodeThatCannotOpenItsDevicesAnewSaysSo) {
  VehicleChange change("old", false);
  change.take(part("new", 0, 1));
  EXPECT_EQ(change.ask(configure("new", 1))->result, CommandError::kVehicleRefused);
}

}  // namespace
}  // namespace roadbalance

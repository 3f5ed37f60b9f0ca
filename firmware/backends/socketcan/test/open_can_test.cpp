#include "firmware/backends/socketcan/open_can.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "common/config/section.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

constexpr const char* kCar = R"(
BO_ 514 Wheels: 8 X
 SG_ Left : 7|16@0+ (0.01,0) [0|300] "km/h" X
)";

/// The demonstration car, whose node "front" has an interface that no machine has.
class OpenCanTest : public testing::Test {
 protected:
  OpenCanTest() : vehicle(VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "vehicle.toml")) {
    std::ofstream(folder.path() / "car.dbc") << kCar;
    vehicle.folder = folder.path();
    vehicle.node[0].rate_hz = 1'000;
    vehicle.node[0].wiring.can = {CanConfig{.interface = "can77",
                                            .role = CanRole::kSensor,
                                            .dbc = "car.dbc",
                                            .accelerometer_id = {},
                                            .signal = {}}};
  }
  CanConfig& can() { return vehicle.node[0].wiring.can[0]; }
  void want_signal() {
    can().signal = {{.name = "speed",
                     .message = "Wheels",
                     .signal = "Left",
                     .quantity = SignalQuantity::kOther,
                     .wheel = {}}};
  }
  std::string refusal(const std::string& address = "can77") const {
    try {
      open_can({.address = address, .vehicle = vehicle, .node = vehicle.node[0]}, [](const std::string&) {});
    } catch (const ConfigError& error) {
      return error.what();
    } catch (const CanError& error) {
      return error.what();
    }
    return "accepted";
  }
  const test::TemporaryDirectory folder;
  VehicleConfig vehicle;
};

TEST_F(OpenCanTest, RefusesAnInterfaceThatTheNodeDoesNotDescribe) {
  EXPECT_EQ(refusal("can5"),
            "front end \"can:can5\": node front has no [[node.can]] with interface = \"can5\"");
}

TEST_F(OpenCanTest, RefusesAnInterfaceOfWhichNothingIsWanted) {
  EXPECT_EQ(
      refusal(),
      "front end \"can:can77\": nothing is wanted of it; allowed: [[node.can.signal]], accelerometer_id");
}

TEST_F(OpenCanTest, RefusesAModuleInANodeOfAnotherRate) {
  can().accelerometer_id = 0x200;
  vehicle.node[0].rate_hz = 2'000;
  EXPECT_EQ(
      refusal().find("accelerometer on can77: it converts 1000 times a second, but rate_hz of node front "
                     "is 2000"),
      0U)
      << refusal();
}

TEST_F(OpenCanTest, RefusesAModuleWhoseIdentifiersASignalHas) {
  want_signal();
  for (const std::uint32_t first : {0x1FFU, 0x200U, 0x202U}) {
    can().accelerometer_id = first;
    EXPECT_EQ(refusal(), "accelerometer on can77: identifier 514 is also that of a signal in car.dbc");
  }
  for (const std::uint32_t first : {0x1FEU, 0x203U}) {
    can().accelerometer_id = first;  // beside it
    EXPECT_EQ(refusal(), "CAN interface can77: there is none of that name; try: ip link show type can");
  }
}

TEST_F(OpenCanTest, FindsTheDbcFileBesideTheVehiclesAndThenAsksForTheInterface) {
  want_signal();
  EXPECT_EQ(refusal(), "CAN interface can77: there is none of that name; try: ip link show type can");
  can().dbc = "other.dbc";
  EXPECT_ANY_THROW(refusal());
}

}  // namespace
}  // namespace roadbalance

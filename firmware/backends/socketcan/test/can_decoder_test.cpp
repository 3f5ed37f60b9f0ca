#include "firmware/backends/socketcan/can_decoder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "common/config/section.hpp"
#include "common/dbc/candump.hpp"
#include "common/test/no_allocation.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

constexpr const char* kCar = R"(
BO_ 170 Wheels: 8 X
 SG_ Left : 7|16@0+ (0.01,0) [0|300] "km/h" X
 SG_ Right : 23|16@0+ (1,0) [0|3000] "1/min" X
 SG_ Count : 39|8@0+ (1,0) [0|255] "" X
 SG_ Odd : 47|8@0+ (1,0) [0|255] "furlong" X
BO_ 2147483818 Steering: 2 X
 SG_ Angle : 7|16@0- (0.1,0) [-720|720] "deg" X
BO_ 200 Transported: 100 X
 SG_ Far : 0|8@1+ (1,0) [0|255] "" X
)";

VehicleConfig demo_car() {
  return VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "vehicle.toml");
}

SignalConfig signal(const std::string& message, const std::string& name, SignalQuantity quantity) {
  return {
      .name = "my " + name, .message = message, .signal = name, .quantity = quantity, .wheel = "front_right"};
}

CanDecoder decoder(const std::vector<SignalConfig>& signals, int first = 0) {
  CanConfig can;
  can.signal = signals;
  can.first_signal = first;
  return CanDecoder(can, demo_car(), Dbc::parse(kCar, "car.dbc"));
}

CanFrame frame(const std::string& text) {
  return parse_candump("(1.000000) can0 " + text).value().frame;
}

constexpr NodeTime kTime = node_time_from_ns(123);

TEST(CanDecoder, GivesSamplesInTheUnitOfTheirQuantity) {
  const CanDecoder car = decoder({signal("Wheels", "Left", SignalQuantity::kWheelSpeed),
                                  signal("Steering", "Angle", SignalQuantity::kSteeringAngle),
                                  signal("Wheels", "Right", SignalQuantity::kWheelSpeed),
                                  signal("Wheels", "Count", SignalQuantity::kPulseCounter),
                                  signal("Wheels", "Odd", SignalQuantity::kOther)},
                                 3);
  const std::vector<CanId> ids = car.ids();
  EXPECT_EQ(ids, (std::vector<CanId>{{170, false}, {170, true}}));
  std::array<SignalSample, CanDecoder::kMostOfOneFrame> samples;
  const CanFrame wheels_frame = frame("0AA#2328025811070000");
  const CanFrame steering_frame = frame("000000AA#FC7C");
  DeviceReport report("can:can0");
  const test::NoAllocation guard;
  // 9000 counts are 90 km/h; 600 1/min of a wheel of 0.30 m are 20 pi rad/s times 0.30 m.
  ASSERT_EQ(car.decode(wheels_frame, kTime, samples, report), 4U);
  EXPECT_EQ(samples[0].signal, 3);
  EXPECT_NEAR(samples[0].value, 25.0, 1e-12);
  EXPECT_EQ(samples[0].time, kTime);
  EXPECT_EQ(samples[1].signal, 5);
  EXPECT_NEAR(samples[1].value, 6.0 * std::numbers::pi, 1e-12);
  EXPECT_EQ(samples[2].value, 17.0);
  EXPECT_EQ(samples[3].value, 7.0);  // as the DBC file gives it
  ASSERT_EQ(car.decode(steering_frame, kTime, samples, report), 1U);
  EXPECT_EQ(report.of(DeviceCounter::kFramesRefused), 0);
  EXPECT_EQ(samples[0].signal, 4);
  EXPECT_NEAR(samples[0].value, -90.0 * std::numbers::pi / 180.0, 1e-12);
}

TEST(CanDecoder, RefusesAShortFrameAndAValueOutOfRangeButKeepsTheOthers) {
  const CanDecoder car = decoder({signal("Wheels", "Left", SignalQuantity::kWheelSpeed),
                                  signal("Wheels", "Count", SignalQuantity::kPulseCounter)});
  std::array<SignalSample, CanDecoder::kMostOfOneFrame> samples;
  DeviceReport report("can:can0");
  EXPECT_EQ(car.decode(frame("0AA#23280258110700"), kTime, samples, report), 0U);
  EXPECT_EQ(report.of(DeviceCounter::kFramesRefused), 1);
  ASSERT_EQ(car.decode(frame("0AA#FFFF025811070000"), kTime, samples, report), 1U);
  EXPECT_EQ(report.of(DeviceCounter::kFramesRefused), 2);
  EXPECT_EQ(samples[0].value, 17.0);
}

TEST(CanDecoder, PassesOverFramesThatNobodyWants) {
  const CanDecoder car = decoder({signal("Wheels", "Left", SignalQuantity::kWheelSpeed)});
  std::array<SignalSample, CanDecoder::kMostOfOneFrame> samples;
  DeviceReport report("can:can0");
  for (const char* other : {"0AB#2328025811070000", "000000AA#2328025811070000"})
    EXPECT_EQ(car.decode(frame(other), kTime, samples, report), 0U);
  EXPECT_EQ(report.of(DeviceCounter::kFramesRefused), 0);
}

TEST(CanDecoder, NamesTheSignalAndItsLineWhenItCannotBeUsed) {
  const auto error_of = [](const SignalConfig& wanted) -> std::string {
    try {
      decoder({wanted});
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(error_of(signal("Nothing", "Left", SignalQuantity::kOther)),
            "signal \"my Left\": car.dbc has no message Nothing");
  EXPECT_EQ(error_of(signal("Wheels", "Nothing", SignalQuantity::kOther)),
            "signal \"my Nothing\": car.dbc:2: message Wheels has no signal Nothing");
  EXPECT_EQ(error_of(signal("Wheels", "Odd", SignalQuantity::kVehicleSpeed)),
            "signal \"my Odd\": car.dbc:6: Odd has unit \"furlong\"; allowed for its quantity: km/h, kph, "
            "mph, m/s");
  EXPECT_EQ(error_of(signal("Wheels", "Right", SignalQuantity::kVehicleSpeed)),
            "signal \"my Right\": car.dbc:4: Right has unit \"1/min\"; allowed for its quantity: km/h, kph, "
            "mph, m/s");
  EXPECT_EQ(error_of(signal("Wheels", "Left", SignalQuantity::kSteeringAngle)),
            "signal \"my Left\": car.dbc:3: Left has unit \"km/h\"; allowed for its quantity: deg, rad");
  EXPECT_EQ(error_of(signal("Transported", "Far", SignalQuantity::kOther)),
            "signal \"my Far\": car.dbc:9: message Transported has 100 bytes; allowed: 64, one frame");
}

}  // namespace
}  // namespace roadbalance

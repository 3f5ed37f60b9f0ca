#include "firmware/backends/gpio/gpio_input.hpp"

#include <gtest/gtest.h>

#include "common/config/section.hpp"
#include "firmware/test/vehicle.hpp"

namespace roadbalance {
namespace {

/// LineConfig: line, tooth_gpio, direction_gpio, zero_mark_gpio.
struct Wired {
  explicit Wired(std::vector<LineConfig> lines, int teeth = 96)
      : vehicle(test::one_node_vehicle(2000.0, teeth)) {
    vehicle.node[0].wiring.line = std::move(lines);
  }
  std::vector<GpioInput> inputs() {
    return gpio_inputs("gpio:gpiochip0", vehicle, vehicle.node[0],
                       [this](const std::string& text) { warnings += text + '\n'; });
  }
  bool warned_of(const std::string& text) const { return warnings.find(text) != std::string::npos; }

  VehicleConfig vehicle;
  std::string warnings;
};

TEST(GpioInputs, AreTheTracksOfTheLinesWithTheKeysThatNameThem) {
  Wired wired({{0, 4, {}, 5}, {1, 6, 7, 8}});
  const auto inputs = wired.inputs();
  ASSERT_EQ(inputs.size(), 5U);
  EXPECT_EQ(inputs[1].offset, 5U);
  EXPECT_EQ(inputs[1].track, GpioTrack::kZeroMark);
  EXPECT_EQ(inputs[1].key, "[[node.line]] line 0 of node axle: zero_mark_gpio");
  EXPECT_EQ(inputs[3].offset, 7U);
  EXPECT_EQ(inputs[3].line, 1);
  EXPECT_EQ(inputs[3].track, GpioTrack::kDirection);
  EXPECT_EQ(wired.warnings, "");
}

TEST(GpioInputs, ANodeWithoutLinesIsRefused) {
  Wired wired({});
  try {
    wired.inputs();
    FAIL();
  } catch (const ConfigError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("gpio:gpiochip0"), std::string::npos) << what;
    EXPECT_NE(what.find("[[node.line]]"), std::string::npos) << what;
    EXPECT_NE(what.find("axle"), std::string::npos) << what;
  }
}

TEST(GpioInputs, AWheelThatGetsNoEdgesOrNoAngleIsWarnedOf) {
  Wired wired({{0, 4, {}, {}}});
  wired.inputs();
  EXPECT_TRUE(wired.warned_of("no zero_mark_gpio, so the angle of wheel front_left will never be known"));
  EXPECT_TRUE(wired.warned_of("wheel front_right has its encoder on line 1 of node axle")) << wired.warnings;

  Wired unused({{0, 4, {}, 5}, {1, 6, {}, 7}});
  unused.vehicle.wheel[1].node = "";
  unused.vehicle.wheel[0].encoder.zero_mark = false;
  unused.inputs();
  EXPECT_TRUE(unused.warned_of("line 1 of node axle: no wheel")) << unused.warnings;
  EXPECT_TRUE(unused.warned_of("zero_mark_gpio is not used")) << unused.warnings;
}

// 1000 pulses at 60 turns a second are 60 kHz; a ring of 96 teeth stays below 6.
TEST(GpioInputs, AnEncoderTooFastForGpioIsSentToTheBoard) {
  Wired fast({{0, 4, {}, 5}, {1, 6, 7, 8}}, 1000);
  fast.inputs();
  EXPECT_TRUE(fast.warned_of("front_left gives up to 60 kHz")) << fast.warnings;
  EXPECT_TRUE(fast.warned_of("front_right gives up to 120 kHz")) << fast.warnings;
  EXPECT_TRUE(fast.warned_of("USB board"));
}

}  // namespace
}  // namespace roadbalance

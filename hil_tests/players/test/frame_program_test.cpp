#include "hil_tests/players/frame_program.hpp"

#include <gtest/gtest.h>

#include "common/config/section.hpp"
#include "common/test/source.hpp"
#include "firmware/backends/socketcan/can_decoder.hpp"

namespace roadbalance::test {
namespace {

const VehicleConfig& vehicle() {
  static const VehicleConfig vehicle =
      VehicleConfig::read_file(source_path("hil_tests/players/demo/vehicle.toml"));
  return vehicle;
}

SignalSample sample(std::int64_t ms, std::uint16_t signal, double value) {
  return {.time = node_time_from_ns(1'000'000 * ms), .signal = signal, .value = value};
}

// In car.dbc the car's speed is 16 bits, big-endian, of 0.01 km/h: 27.5 m/s = 99 km/h = 9900 = 0x26AC.  The
// steering wheel's angle is signed, of 0.1 degrees: -30 degrees = -300 = 0xFED4.
TEST(FrameProgram, SaysWhatTheDbcFileDescribes) {
  NodeDrive drive;
  drive.signals = {sample(10, 0, 27.5), sample(20, 5, -30.0 * std::numbers::pi / 180.0)};
  FrameProgram program;
  program.add(vehicle(), vehicle().node[0], drive);
  ASSERT_EQ(program.interfaces(), std::vector<std::string>{"vcan0"});
  const auto frames = program.take();
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(to_ns(frames[0].time), 10'000'000);
  EXPECT_EQ(frames[0].frame.id, 256U);
  EXPECT_EQ(frames[0].frame.size, 2);
  EXPECT_EQ(frames[0].frame.data[0], 0x26);
  EXPECT_EQ(frames[0].frame.data[1], 0xAC);
  EXPECT_EQ(frames[1].frame.id, 352U);
  EXPECT_EQ(frames[1].frame.data[0], 0xFE);
  EXPECT_EQ(frames[1].frame.data[1], 0xD4);
}

// Both nodes hear the wheels' message, each for its own two wheels: it is sent once.
TEST(FrameProgram, MessagesThatSeveralNodesHearAreSentOnce) {
  NodeDrive front, rear;
  front.signals = {sample(10, 1, 20.0), sample(10, 2, 21.0)};
  rear.signals = {sample(10, 1, 22.0), sample(10, 2, 23.0), sample(20, 1, 24.0)};
  FrameProgram program;
  program.add(vehicle(), vehicle().node[0], front);
  program.add(vehicle(), vehicle().node[1], rear);
  const auto frames = program.take();
  ASSERT_EQ(frames.size(), 2U);

  const Dbc dbc = Dbc::read_file(source_path("hil_tests/players/demo/car.dbc"));
  const CanDecoder at_front(vehicle().node[0].wiring.can[0], vehicle(), dbc);
  const CanDecoder at_rear(vehicle().node[1].wiring.can[0], vehicle(), dbc);
  std::array<SignalSample, CanDecoder::kMostOfOneFrame> got;
  constexpr double kHalfStep_m_s = 0.5 * 0.01 / 3.6;
  DeviceReport report("can:vcan0");
  ASSERT_EQ(at_front.decode(frames[0].frame, {}, got, report), 2U);
  EXPECT_NEAR(got[0].value, 20.0, kHalfStep_m_s);
  EXPECT_NEAR(got[1].value, 21.0, kHalfStep_m_s);
  ASSERT_EQ(at_rear.decode(frames[1].frame, {}, got, report), 2U);
  EXPECT_NEAR(got[0].value, 24.0, kHalfStep_m_s) << "new";
  EXPECT_NEAR(got[1].value, 23.0, kHalfStep_m_s) << "as it was";
}

// Signals that the node would not take from the bus are not played.
TEST(FrameProgram, RefusesAUnitThatDoesNotGoWithTheQuantity) {
  VehicleConfig other = vehicle();
  other.node[0].wiring.can[0].signal[0].quantity = SignalQuantity::kSteeringAngle;  // it is in km/h
  FrameProgram program;
  EXPECT_THROW(program.add(other, other.node[0], {}), ConfigError);
}

TEST(FrameProgram, RefusesAValueThatTheMessageCannotSay) {
  NodeDrive drive;
  drive.signals = {sample(10, 0, -1.0)};
  FrameProgram program;
  program.add(vehicle(), vehicle().node[0], drive);
  EXPECT_THROW(program.take(), ConfigError);
}

}  // namespace
}  // namespace roadbalance::test

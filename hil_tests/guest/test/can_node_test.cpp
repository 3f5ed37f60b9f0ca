#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "common/frontend/device_report.hpp"
#include "common/test/source.hpp"
#include "hil_tests/guest/running_module.hpp"
#include "hil_tests/measurement.hpp"

namespace roadbalance {
namespace {

using test::ip;
using test::Program;
using test::RunningModule;

/// rb-node with an accelerometer module on a cable, recorded.
class CanNodeTest : public test::Measurement {
 protected:
  void SetUp() override {
    ip("link add vx0 type vxcan peer name vx1");
    ip("link set vx0 up");
    ip("link set vx1 up");
    std::string text = test::read_source("sim/demo/vehicle.toml");
    for (std::size_t at; (at = text.find("rate_hz = 2000")) != std::string::npos;)
      text.replace(at, 14, "rate_hz = 1000");
    const std::string wiring =
        "[[node.can]]\ninterface = \"vx0\"\nrole = \"sensor\"\naccelerometer_id = 512\n";
    text.insert(text.find("[[node.channel]]"), wiring);
    std::ofstream(vehicle) << text;
  }
  void TearDown() override {
    if (test::has_interface("vx0")) ip("link del vx0");
  }
  Program node_on_can() const {
    const std::string command =
        "exec \"$0\" --vehicle \"$1\" --node front --front-end can:vx0 --url \"$2\" 2>\"$3\"";
    return {"bash", {"-c", command, test::binaries() / "rb-node", vehicle, url, errors}};
  }
  bool counted(DeviceCounter counter, std::int64_t times) {
    return bus.wait(
        [&] { return bus.heartbeat(kFront).device_counts[static_cast<std::size_t>(counter)] == times; });
  }
  const std::string vehicle = work.path() / "vehicle.toml";
  const std::string errors = work.path() / "errors";
};

TEST_F(CanNodeTest, DeclaresWhatItsModuleLostAndWhatWentByWhileTheInterfaceWasDown) {
  RunningModule module("vx1");
  Program running = recorder();
  Program front = node_on_can();
  ASSERT_TRUE(more_are_durable(kFront, 20));
  module.lose(25);
  ASSERT_TRUE(counted(DeviceCounter::kPacketsMissing, 25));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  ip("link set vx0 down");
  ASSERT_TRUE(counted(DeviceCounter::kGone, 1));
  ip("link set vx0 up");
  ASSERT_TRUE(counted(DeviceCounter::kReturned, 1));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  const std::int64_t missing =
      bus.heartbeat(kFront).device_counts[static_cast<std::size_t>(DeviceCounter::kPacketsMissing)];
  EXPECT_GT(missing, 25);
  end_well(running, {&front});

  const Verification verified = verify_record(record);
  EXPECT_EQ(verified.verdict, Verdict::kIncomplete) << verdict_text(verified);
  ASSERT_EQ(verified.epoch.size(), 1U);
  const VerifiedEpoch& epoch = verified.epoch[0];
  EXPECT_FALSE(epoch.is_damaged());
  ASSERT_EQ(epoch.gaps.size(), 2U);
  EXPECT_EQ(epoch.gaps[0].cause, GapCause::kDeviceOverrun);
  EXPECT_EQ(epoch.gaps[0].scans, 25);
  EXPECT_EQ(epoch.gaps[1].cause, GapCause::kDeviceGone);
  EXPECT_EQ(epoch.gaps[1].scans, missing - 25);

  std::ifstream file(errors);
  const std::string said((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  for (const char* sentence :
       {"can:vx0: packets are missing (25 times by now)",
        "can:vx0: was unplugged or went down (1 time by now)", "can:vx0: is there again (1 time by now)"})
    EXPECT_NE(said.find(sentence), std::string::npos) << sentence << " is not in: " << said;
}

TEST_F(CanNodeTest, DoesNotBeginOnAnInterfaceThatIsDown) {
  ip("link set vx0 down");
  Program front = node_on_can();
  EXPECT_EQ(front.exit_code(bus.kPatience_s), 2);
  std::ifstream file(errors);
  const std::string said((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  EXPECT_NE(said.find("CAN interface vx0 is down; try: ip link set vx0 up"), std::string::npos) << said;
}

}  // namespace
}  // namespace roadbalance

#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "firmware/backends/socketcan/accelerometer_frame.hpp"
#include "hil_tests/guest/device_measurement.hpp"
#include "hil_tests/guest/recorded_parts.hpp"
#include "hil_tests/guest/running_module.hpp"
#include "hil_tests/guest/serial_can.hpp"
#include "hil_tests/guest/speed_message.hpp"

namespace roadbalance {
namespace {

using test::AccelerometerModule;
using test::CanPlayer;
using test::ip;
using test::Program;
using test::RunningModule;
using test::SerialCan;
using test::SpeedMessage;

constexpr int kRate_hz = 1000;  // the module's

/// Frames that an interface has sent since it was made.
std::int64_t sent_by(const std::string& interface) {
  std::int64_t frames = -1;
  std::ifstream("/sys/class/net/" + interface + "/statistics/tx_packets") >> frames;
  return frames;
}

/// rb-node with an accelerometer module on a cable, recorded.
class CanNodeTest : public test::DeviceMeasurement {
 protected:
  void SetUp() override {
    wire_module("vx0");
    std::ofstream(work.path() / "car.dbc") << SpeedMessage::kDbc;
  }
  void wire_module(const std::string& interface, const std::string& more = {}) const {
    wire(test::RunningModule::wiring(interface) + more, kRate_hz);
  }

  const test::VirtualCan cable{"vx0", "vx1"};
};

TEST_F(CanNodeTest, DeclaresWhatItsModuleLostAndWhatWentByWhileTheInterfaceWasDown) {
  RunningModule module("vx1");
  Program running = recorder();
  Program front = device_node({"can:vx0"});
  ASSERT_TRUE(more_are_durable(kFront, 20));
  module.lose(25);
  ASSERT_TRUE(counted(DeviceCounter::kPacketsMissing, 25));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  ip("link set vx0 down");
  ASSERT_TRUE(counted(DeviceCounter::kGone, 1));
  ip("link set vx0 up");
  ASSERT_TRUE(counted(DeviceCounter::kReturned, 1));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  const std::int64_t missing = bus.heartbeat(kFront).scans_missing;
  EXPECT_GT(missing, 25);
  EXPECT_EQ(count_of(DeviceCounter::kPacketsMissing), 25) << "what was not there is not missing packets";
  end_well(running, {&front});
  EXPECT_EQ(sent_by("vx0"), 0) << "the node sends nothing";
  EXPECT_GT(sent_by("vx1"), 0) << "as its module does";

  const auto found = gaps();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].cause, GapCause::kDeviceOverrun);
  EXPECT_EQ(found[0].scans, 25);
  EXPECT_EQ(found[1].cause, GapCause::kDeviceGone);
  EXPECT_EQ(found[1].scans, missing - 25);
  expect_said("can:vx0", {"packets are missing (25 times by now)",
                          "was unplugged or went down (1 time by now)", "is there again (1 time by now)"});
}

TEST_F(CanNodeTest, SaysThatNoScanOfItsModuleComesAndWhatMayBeWhy) {
  ip("link set vx0 down");
  ip("link set vx0 mtu 16");  // classic CAN only
  ip("link set vx0 up");
  Program running = recorder();
  Program front = device_node({"can:vx0"});
  const std::string sentence =
      "can:vx0: no scan of the accelerometer module comes (identifiers 0x200 to 0x203)";
  const auto times = [&] {
    const std::string all = said();
    int found = 0;
    for (auto at = all.find(sentence); at != std::string::npos; at = all.find(sentence, at + 1)) ++found;
    return found;
  };
  EXPECT_TRUE(bus.wait([&] { return times() == 1; })) << said();
  EXPECT_NE(said().find(sentence + "; vx0 carries no CAN FD, in case the module sends that"),
            std::string::npos)
      << said();
  ip("link set vx0 down");
  ip("link set vx0 mtu 72");
  ip("link set vx0 up");
  std::optional<RunningModule> module;
  module.emplace("vx1");
  ASSERT_TRUE(more_are_durable(kFront, 20));
  const std::int64_t gone = count_of(DeviceCounter::kGone);
  module.reset();  // its power is gone
  EXPECT_TRUE(bus.wait([&] { return times() == 2; })) << said();
  EXPECT_TRUE(counted(DeviceCounter::kGone, gone + 1));
  module.emplace("vx1");  // what a node has begun ends with its next scans
  EXPECT_TRUE(counted(DeviceCounter::kReturned, gone + 1));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  end_well(running, {&front});
  const auto found = gaps();
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.back().cause, GapCause::kDeviceGone);
  EXPECT_GT(found.back().scans, 2'000);
}

TEST_F(CanNodeTest, DeclaresWhatAFloodCostsWhileItIsHeld) {
  wire_module("vx0", SpeedMessage::kSignal);
  RunningModule module("vx1");
  CanPlayer car("vx1");
  Program running = recorder();
  Program front = device_node({"can:vx0"});
  ASSERT_TRUE(more_are_durable(kFront, 20));
  front.signal(SIGSTOP);
  constexpr int kFlood = 60'000;  // the kernel has room for less
  for (int k = 0; k < kFlood; ++k) car.send(SpeedMessage::frame(1'000));
  bus.listen(0.2);  // the module's conversions find no room
  front.signal(SIGCONT);
  ASSERT_TRUE(bus.wait([&] { return count_of(DeviceCounter::kQueueOverflow) > 0; }));
  ASSERT_TRUE(bus.wait([&] { return count_of(DeviceCounter::kPacketsMissing) >= 150; }));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  // Until a few heartbeats agree.
  const auto counts = [&] { return bus.heartbeat(kFront).device_counts; };
  auto before = counts();
  for (int still = 0, tries = 0; still < 3 && tries < 100; ++tries) {
    bus.listen(0.3);
    still = counts() == before ? still + 1 : 0;
    before = counts();
  }
  const std::int64_t missing = count_of(DeviceCounter::kPacketsMissing);
  const std::int64_t overflow = count_of(DeviceCounter::kQueueOverflow);
  const std::int64_t too_slow = count_of(DeviceCounter::kReadersTooSlow);
  end_well(running, {&front});

  std::int64_t scans = 0;
  for (const VerifiedGap& gap : gaps()) {
    EXPECT_EQ(gap.cause, GapCause::kDeviceOverrun);
    scans += gap.scans;
  }
  EXPECT_EQ(scans, missing);
  const auto signals = static_cast<std::int64_t>(test::recorded_events(record, kFront).signals.size());
  // Every frame was recorded or counted.  Those that were lost are of the flood and of the module.
  EXPECT_EQ(signals + overflow + too_slow, kFlood + missing);
  expect_said("can:vx0", {sentence(DeviceCounter::kQueueOverflow, overflow)});
}

TEST_F(CanNodeTest, RecordsSignalsAsTheyWereSentAndRefusesFramesThatCannotBe) {
  const test::VirtualCan bus_of_the_car("vcan5");
  wire_module("vx0", std::string("[[node.can]]\ninterface = \"vcan5\"\nrole = \"vehicle\"\n") +
                         SpeedMessage::kSignal);
  RunningModule module("vx1");
  CanPlayer car("vcan5");
  Program running = recorder();
  Program front = device_node({"can:vx0", "can:vcan5"});
  ASSERT_TRUE(more_are_durable(kFront, 20));
  constexpr int kFrames = 300;
  for (int k = 0; k < kFrames; ++k) {
    car.send(SpeedMessage::frame(static_cast<std::uint16_t>(100 * k)));
    if (k == 100) {
      CanFrame short_one = SpeedMessage::frame(1'234);
      short_one.size = 1;
      car.send(short_one);
    }
    if (k == 200) car.send(SpeedMessage::frame(30'001));  // 300.01 km/h
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(counted(DeviceCounter::kFramesRefused, 2));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  end_well(running, {&front});

  expect_verified(record, 1);  // signals are not scans: none is missing
  const std::vector<SignalSample> signals = test::recorded_events(record, kFront).signals;
  ASSERT_EQ(signals.size(), static_cast<std::size_t>(kFrames));
  for (int k = 0; k < kFrames; ++k) {
    const SignalSample& sample = signals[static_cast<std::size_t>(k)];
    EXPECT_EQ(sample.signal, 0);
    EXPECT_NEAR(sample.value, k / 3.6, 1e-9);
    if (k > 0) {
      EXPECT_GT(sample.time, signals[static_cast<std::size_t>(k) - 1].time);
    }
  }
  expect_said("can:vcan5",
              {"frames were refused: wrong length, or a value out of its range (2 times by now)"});
}

/// The module on the serial adapter's bus: the frames of a conversion in the adapter's words.
std::string conversion(std::uint32_t number) {
  constexpr const char* kDigits = "0123456789ABCDEF";
  std::string words;
  for (int part = 0; part < AccelerometerFrame::kParts; ++part) {
    AccelerometerFrame said{.sequence = number, .part = part};
    const CanFrame frame = write_accelerometer(said, AccelerometerModule::kFirstId);
    words += (part == 0 ? "t20" : "\rt20") + std::to_string(part) + "8";
    for (std::size_t k = 0; k < frame.size; ++k)
      words += {kDigits[frame.data[k] >> 4], kDigits[frame.data[k] & 0xF]};
  }
  return words;
}

TEST_F(CanNodeTest, SaysWhatTheControllerSuffersAndDeclaresWhatWentByWhileTheBusWasOff) {
  const SerialCan adapter;
  const std::string can = adapter.interface();
  ip("link set " + can + " type can bitrate 1000000");
  ip("link set " + can + " up");
  wire_module(can);
  Program running = recorder();
  Program front = device_node({"can:" + can});
  std::atomic<bool> is_off = false;
  const std::jthread module([&](const std::stop_token& stop) {
    auto due = WallClock::now();
    for (std::uint32_t number = 0; !stop.stop_requested(); ++number) {
      std::this_thread::sleep_until(due += std::chrono::milliseconds(1));
      if (!is_off) adapter.report(conversion(number));
    }
  });
  ASSERT_TRUE(more_are_durable(kFront, 20));
  adapter.report("e1a");  // not acknowledged
  ASSERT_TRUE(counted(DeviceCounter::kBusErrors, 1));
  adapter.report("e1o");  // the controller had no room
  ASSERT_TRUE(counted(DeviceCounter::kControllerOverrun, 1));
  adapter.report("sp130130");
  ASSERT_TRUE(counted(DeviceCounter::kErrorPassive, 1));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  EXPECT_EQ(count_of(DeviceCounter::kPacketsMissing), 0) << "none of this lost a conversion";
  is_off = true;
  adapter.report("sb256256");
  ASSERT_TRUE(counted(DeviceCounter::kBusOff, 1));
  ip("link set " + can + " down");
  ASSERT_TRUE(counted(DeviceCounter::kGone, 1));
  ip("link set " + can + " up");
  ASSERT_TRUE(counted(DeviceCounter::kReturned, 1));
  is_off = false;
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).scans_missing > 0; }));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  const std::int64_t missing = bus.heartbeat(kFront).scans_missing;
  end_well(running, {&front});

  const auto found = gaps();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].cause, GapCause::kDeviceGone);
  EXPECT_EQ(found[0].scans, missing);
  expect_said("can:" + can,
              {sentence(DeviceCounter::kBusErrors, 1), sentence(DeviceCounter::kControllerOverrun, 1),
               "error-passive: the controller sees many errors on the bus (1 time by now)",
               "bus-off: the controller no longer takes part in the bus (1 time by now)",
               "was unplugged or went down (1 time by now)", "is there again (1 time by now)"});
}

TEST_F(CanNodeTest, DoesNotBeginOnAnInterfaceThatIsDown) {
  ip("link set vx0 down");
  Program front = device_node({"can:vx0"});
  EXPECT_EQ(front.exit_code(bus.kPatience_s), 4) << "systemd tries again";
  EXPECT_NE(said().find("CAN interface vx0 is down; try: ip link set vx0 up"), std::string::npos) << said();
}

}  // namespace
}  // namespace roadbalance

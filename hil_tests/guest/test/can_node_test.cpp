#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/frontend/device_report.hpp"
#include "common/record/record.hpp"
#include "common/test/source.hpp"
#include "firmware/backends/socketcan/accelerometer_frame.hpp"
#include "hil_tests/guest/running_module.hpp"
#include "hil_tests/guest/serial_can.hpp"
#include "hil_tests/measurement.hpp"

namespace roadbalance {
namespace {

using test::AccelerometerModule;
using test::CanPlayer;
using test::ip;
using test::Program;
using test::RunningModule;
using test::SerialCan;

constexpr std::uint32_t kWheels = 0xAA;
constexpr const char* kCar = R"(
BO_ 170 Wheels: 8 X
 SG_ Left : 7|16@0+ (0.01,0) [0|300] "km/h" X
)";

/// rb-node with an accelerometer module on a cable, recorded.
class CanNodeTest : public test::Measurement {
 protected:
  void SetUp() override {
    ip("link add vx0 type vxcan peer name vx1");
    ip("link set vx0 up");
    ip("link set vx1 up");
    wire(wiring_of_module("vx0"));
  }
  void TearDown() override {
    if (test::has_interface("vx0")) ip("link del vx0");
  }
  static std::string wiring_of_module(const std::string& interface) {
    return "[[node.can]]\ninterface = \"" + interface +
           "\"\nrole = \"sensor\"\naccelerometer_id = " + std::to_string(AccelerometerModule::kFirstId) +
           "\n";
  }
  /// Of the interface described last.
  static std::string wiring_of_signal() {
    return "dbc = \"car.dbc\"\n[[node.can.signal]]\nname = \"speed\"\nmessage = \"Wheels\"\nsignal = "
           "\"Left\"\n"
           "quantity = \"vehicle_speed\"\n";
  }
  void wire(const std::string& wiring) const {
    std::string text = test::read_source("sim/demo/vehicle.toml");
    for (std::size_t at; (at = text.find("rate_hz = 2000")) != std::string::npos;)
      text.replace(at, 14, "rate_hz = 1000");
    text.insert(text.find("[[node.channel]]"), wiring);
    std::ofstream(vehicle) << text;
    std::ofstream(work.path() / "car.dbc") << kCar;
  }
  static CanFrame wheels(std::uint16_t raw) {
    CanFrame frame{.id = kWheels, .size = 8};
    frame.data[0] = static_cast<std::uint8_t>(raw >> 8);
    frame.data[1] = static_cast<std::uint8_t>(raw);
    return frame;
  }
  Program node_on_can(const std::string& devices = "--front-end can:vx0") const {
    const std::string command =
        "exec \"$0\" --vehicle \"$1\" --node front " + devices + " --url \"$2\" 2>\"$3\"";
    return {"bash", {"-c", command, test::binaries() / "rb-node", vehicle, url, errors}};
  }
  std::int64_t count_of(DeviceCounter counter) const {
    return bus.heartbeat(kFront).device_counts[static_cast<std::size_t>(counter)];
  }
  bool counted(DeviceCounter counter, std::int64_t times) {
    return bus.wait([&] { return count_of(counter) == times; });
  }
  /// The node prints it and the record keeps it.
  void expect_said(const std::vector<std::string>& sentences) const {
    std::ifstream file(errors);
    const std::string said((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    const std::vector<std::string> notes = verify_record(record).notes;
    for (const std::string& sentence : sentences) {
      EXPECT_NE(said.find(sentence), std::string::npos) << sentence << " is not in: " << said;
      EXPECT_TRUE(std::ranges::any_of(notes,
                                      [&](const std::string& note) {
                                        return note.find("devices of node 1") != std::string::npos &&
                                               note.find(sentence.substr(sentence.find(' ') + 1)) !=
                                                   std::string::npos;
                                      }))
          << sentence << " is no note of the record";
    }
  }
  std::vector<SignalSample> recorded_signals() const {
    std::vector<SignalSample> samples;
    RecordReader reader(record);
    reader.finish();
    SealedBlock block;
    while (const auto event = reader.next())
      if (accept(event->data, block) == Refusal::kNone && block.kind == BlockKind::kSignal)
        for (const SignalSample& sample : decode_signal(block).unpack()) samples.push_back(sample);
    return samples;
  }
  /// The one epoch's gaps; all else of the record must be sound.
  std::vector<VerifiedGap> gaps() const {
    const Verification verified = verify_record(record);
    EXPECT_EQ(verified.verdict, Verdict::kIncomplete) << verdict_text(verified);
    EXPECT_EQ(verified.epoch.size(), 1U);
    if (verified.epoch.size() != 1) return {};
    EXPECT_FALSE(verified.epoch[0].is_damaged());
    return verified.epoch[0].gaps;
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
  const std::int64_t missing = count_of(DeviceCounter::kPacketsMissing);
  EXPECT_GT(missing, 25);
  end_well(running, {&front});

  const auto found = gaps();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].cause, GapCause::kDeviceOverrun);
  EXPECT_EQ(found[0].scans, 25);
  EXPECT_EQ(found[1].cause, GapCause::kDeviceGone);
  EXPECT_EQ(found[1].scans, missing - 25);
  expect_said({"can:vx0: packets are missing (25 times by now)",
               "can:vx0: was unplugged or went down (1 time by now)",
               "can:vx0: is there again (1 time by now)"});
}

TEST_F(CanNodeTest, DeclaresWhatAFloodCostsWhileItIsHeld) {
  wire(wiring_of_module("vx0") + wiring_of_signal());
  RunningModule module("vx1");
  CanPlayer car("vx1");
  Program running = recorder();
  Program front = node_on_can();
  ASSERT_TRUE(more_are_durable(kFront, 20));
  front.signal(SIGSTOP);
  constexpr int kFlood = 60'000;  // the kernel has room for less
  for (int k = 0; k < kFlood; ++k) car.send(wheels(1'000));
  bus.listen(0.2);  // the module's conversions find no room
  front.signal(SIGCONT);
  ASSERT_TRUE(bus.wait([&] { return count_of(DeviceCounter::kQueueOverflow) > 0; }));
  ASSERT_TRUE(bus.wait([&] { return count_of(DeviceCounter::kPacketsMissing) >= 150; }));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  bus.listen(1.0);  // the counts of a heartbeat after all this
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
  const auto signals = static_cast<std::int64_t>(recorded_signals().size());
  // Every frame was recorded or counted.  Those that were lost are of the flood and of the module.
  EXPECT_EQ(signals + overflow + too_slow, kFlood + missing);
  expect_said({"can:vx0: frames were lost because the kernel had no room for them (" +
               std::to_string(overflow) + " times by now)"});
}

TEST_F(CanNodeTest, RecordsSignalsAsTheyWereSentAndRefusesFramesThatCannotBe) {
  ip("link add vcan5 type vcan");
  ip("link set vcan5 up");
  wire(wiring_of_module("vx0") + "[[node.can]]\ninterface = \"vcan5\"\nrole = \"vehicle\"\n" +
       wiring_of_signal());
  RunningModule module("vx1");
  CanPlayer car("vcan5");
  Program running = recorder();
  Program front = node_on_can("--front-end can:vx0 --front-end can:vcan5");
  ASSERT_TRUE(more_are_durable(kFront, 20));
  constexpr int kFrames = 300;
  for (int k = 0; k < kFrames; ++k) {
    car.send(wheels(static_cast<std::uint16_t>(100 * k)));
    if (k == 100) {
      CanFrame short_one = wheels(1'234);
      short_one.size = 1;
      car.send(short_one);
    }
    if (k == 200) car.send(wheels(30'001));  // 300.01 km/h
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(counted(DeviceCounter::kFramesRefused, 2));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  end_well(running, {&front});
  ip("link del vcan5");

  expect_verified(record, 1);  // signals are not scans: none is missing
  const std::vector<SignalSample> signals = recorded_signals();
  ASSERT_EQ(signals.size(), static_cast<std::size_t>(kFrames));
  for (int k = 0; k < kFrames; ++k) {
    const SignalSample& sample = signals[static_cast<std::size_t>(k)];
    EXPECT_EQ(sample.signal, 0);
    EXPECT_NEAR(sample.value, k / 3.6, 1e-9);
    if (k > 0) {
      EXPECT_GT(sample.time, signals[static_cast<std::size_t>(k) - 1].time);
    }
  }
  expect_said({"can:vcan5: frames were refused: wrong length, or a value out of its range (2 times by now)"});
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
  wire(wiring_of_module(can));
  Program running = recorder();
  Program front = node_on_can("--front-end can:" + can);
  std::atomic<bool> is_off = false;
  const std::jthread module([&](const std::stop_token& stop) {
    auto due = WallClock::now();
    for (std::uint32_t number = 0; !stop.stop_requested(); ++number) {
      std::this_thread::sleep_until(due += std::chrono::milliseconds(1));
      if (!is_off) adapter.report(conversion(number));
    }
  });
  ASSERT_TRUE(more_are_durable(kFront, 20));
  adapter.report("e1a");  // nobody acknowledged
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
  ASSERT_TRUE(bus.wait([&] { return count_of(DeviceCounter::kPacketsMissing) > 0; }));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  const std::int64_t missing = count_of(DeviceCounter::kPacketsMissing);
  end_well(running, {&front});

  const auto found = gaps();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].cause, GapCause::kDeviceGone);
  EXPECT_EQ(found[0].scans, missing);
  const std::string name = "can:" + can;
  expect_said({name + ": " + sentence(DeviceCounter::kBusErrors, 1),
               name + ": " + sentence(DeviceCounter::kControllerOverrun, 1),
               name + ": error-passive: the controller sees many errors on the bus (1 time by now)",
               name + ": bus-off: the controller no longer takes part in the bus (1 time by now)",
               name + ": was unplugged or went down (1 time by now)",
               name + ": is there again (1 time by now)"});
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

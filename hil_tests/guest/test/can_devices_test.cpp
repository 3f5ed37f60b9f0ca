#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <optional>
#include <sstream>
#include <thread>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/test/no_allocation.hpp"
#include "common/test/source.hpp"
#include "firmware/backends/socketcan/open_can.hpp"
#include "firmware/device_diary.hpp"
#include "hil_tests/guest/accelerometer_module.hpp"
#include "hil_tests/guest/can_player.hpp"
#include "hil_tests/program.hpp"

namespace roadbalance {
namespace {

using test::AccelerometerModule;
using test::ip;
using test::wait_until;

const std::string kData = "common/dbc/test/data/";

VehicleConfig car_with(const CanConfig& can) {
  VehicleConfig vehicle = VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "vehicle.toml");
  vehicle.folder = test::source_path("");
  vehicle.node[0].wiring.can = {can};
  vehicle.node[0].rate_hz = 1'000;
  return vehicle;
}

OpenedDevice open(const CanConfig& can, const CanIntake::Warn& warn) {
  const VehicleConfig vehicle = car_with(can);
  return open_can({.address = can.interface, .vehicle = vehicle, .node = vehicle.node[0]}, warn);
}

TEST(CanSignals, OfARecordedDriveThatCanplayerRepeatsAreThePublishedWheelSpeeds) {
  const test::VirtualCan bus("vcan9");
  CanConfig can;
  can.interface = bus.name();
  can.role = CanRole::kVehicle;
  can.dbc = kData + "rav4.dbc";
  for (const char* wheel : {"FL", "FR", "RL", "RR"})
    can.signal.push_back({.name = wheel,
                          .message = "WHEEL_SPEEDS",
                          .signal = std::string("WHEEL_SPEED_") + wheel,
                          .quantity = SignalQuantity::kWheelSpeed,
                          .wheel = "front_left"});
  const auto device = std::get<std::unique_ptr<SideSource>>(open(can, [](const std::string&) {}));
  test::Program player("canplayer",
                       {"-I", test::source_path(kData + "rav4.candump.log"), bus.name() + "=can0"});
  std::vector<SignalSample> samples;
  std::array<SignalSample, 256> room;
  NodeTime complete{};
  const auto fetch = [&] {
    const SideRead read = device->take({}, room);
    EXPECT_GE(read.complete_until, complete);
    complete = read.complete_until;
    for (std::size_t k = 0; k < read.signals; ++k) samples.push_back(room[k]);
    return read.signals;
  };
  std::optional<int> code;
  while (!(code = player.exit_code(0.02))) fetch();
  ASSERT_EQ(*code, 0);
  wait_until([&] { return fetch() == 0 && samples.size() >= 4 * 4'974; }, 5);
  ASSERT_EQ(samples.size(), 4U * 4'974U);

  std::istringstream table(test::read_source(kData + "rav4_wheel_speed.csv"));
  std::string line, cell;
  std::getline(table, line);
  double first_s = 0.0, off_s = 0.0;
  for (std::size_t k = 0; std::getline(table, line); k += 4) {
    std::istringstream row(line);
    std::getline(row, cell, ',');
    if (k == 0) first_s = std::stod(cell);
    const double elapsed_s = to_seconds(samples[k].time - samples[0].time);
    off_s = std::max(off_s, std::abs(elapsed_s - (std::stod(cell) - first_s)));
    for (std::size_t wheel = 0; wheel < 4; ++wheel) {
      std::getline(row, cell, ',');
      ASSERT_EQ(samples[k + wheel].signal, wheel);
      ASSERT_EQ(samples[k + wheel].time, samples[k].time);
      ASSERT_NEAR(samples[k + wheel].value, std::stod(cell), 5.1e-8) << line;  // the table has nine digits
    }
  }
  for (const DeviceReport* report : device->reports())
    for (std::size_t k = 0; k < kDeviceCounters; ++k)
      EXPECT_EQ(report->of(static_cast<DeviceCounter>(k)), 0) << name_of(static_cast<DeviceCounter>(k));
  EXPECT_LT(off_s, 5e-3);
  std::printf("%zu wheel speeds as published; canplayer kept the log's times within %.1f ms\n",
              samples.size(), 1e3 * off_s);
}

/// Conversions at 1 kHz.
void convert(AccelerometerModule& module, int count) {
  WallTime due = WallClock::now();
  for (int n = 0; n < count; ++n) {
    std::this_thread::sleep_until(due += std::chrono::milliseconds(1));
    module.convert();
  }
}

/// Reads, as acquire does, until the scan of this index has come or none for so long.
std::vector<Scan> read_until(FrontEnd& front_end, std::int64_t index,
                             WallClock::duration patience = std::chrono::seconds(5)) {
  std::vector<Scan> all;
  std::array<Scan, 256> scans;
  std::array<SignalSample, 64> signals;
  all.reserve(100'000);
  WallTime heard = WallClock::now();
  while (WallClock::now() - heard < patience && (all.empty() || all.back().index < index)) {
    const test::NoAllocation guard;
    const Read read = front_end.read(scans, {}, signals);
    EXPECT_EQ(read.status, ReadStatus::kOk);
    if (read.scans > 0) heard = WallClock::now();
    all.insert(all.end(), scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(read.scans));
  }
  return all;
}

class AccelerometerTest : public testing::TestWithParam<bool> {
 protected:
  bool is_fd() const { return GetParam(); }
  std::string node_side() const { return is_fd() ? "vx0" : "can0"; }
  std::string module_side() const { return is_fd() ? "vx1" : "can1"; }
  void SetUp() override {
    if (is_fd()) {
      cable.emplace("vx0", "vx1");
      return;
    }
    for (const char* interface : {"can0", "can1"}) {
      ASSERT_TRUE(test::has_interface(interface)) << "the guest has no CAN controllers";
      ip(std::string("link set ") + interface + " down");
      ip(std::string("link set ") + interface + " type can bitrate 1000000 listen-only off");
      ip(std::string("link set ") + interface + " up");
    }
  }
  std::unique_ptr<FrontEnd> open_module(const CanIntake::Warn& warn = [](const std::string&) {}) const {
    CanConfig can;
    can.interface = node_side();
    can.role = CanRole::kSensor;
    can.accelerometer_id = AccelerometerModule::kFirstId;
    return std::get<std::unique_ptr<FrontEnd>>(open(can, warn));
  }
  /// Lines that the node would print.
  static std::vector<std::string> said(const FrontEnd& front_end) {
    std::vector<std::string> sentences;
    DeviceDiary(front_end.reports()).look([&](const std::string& sentence) {
      sentences.push_back(sentence);
    });
    return sentences;
  }
  static std::int64_t of(const FrontEnd& front_end, DeviceCounter counter) {
    return front_end.reports().at(0)->of(counter);
  }

  std::optional<test::VirtualCan> cable;  // it carries CAN FD
};

TEST_P(AccelerometerTest, GivesEveryConversionOfAThousandASecond) {
  const auto device = open_module();
  EXPECT_EQ(device->scan_stamps(), ScanStamps::kReadOut);
  constexpr int kCount = 5'000;
  AccelerometerModule module(module_side(), is_fd());
  std::jthread converting([&] { convert(module, kCount); });
  const std::vector<Scan> scans = read_until(*device, kCount - 1);
  ASSERT_EQ(scans.size(), static_cast<std::size_t>(kCount));
  for (std::size_t n = 0; n < scans.size(); ++n) {
    ASSERT_EQ(scans[n].index, static_cast<std::int64_t>(n));
    for (std::size_t k = 0; k < 12; ++k)
      ASSERT_EQ(scans[n].counts[k], 256 * static_cast<std::int16_t>(n + 1'000 * k));
    ASSERT_TRUE(n == 0 || scans[n].time > scans[n - 1].time);
  }
  for (std::size_t k = 0; k < kDeviceCounters; ++k)
    EXPECT_EQ(of(*device, static_cast<DeviceCounter>(k)), 0) << name_of(static_cast<DeviceCounter>(k));
}

TEST_P(AccelerometerTest, LeavesOutTheIndicesOfMissingConversionsAndOfAnAbsence) {
  const auto device = open_module();
  AccelerometerModule module(module_side(), is_fd());
  convert(module, 100);
  module.skip(25);  // lost on the way: the time they take passes, too
  ASSERT_FALSE(wait_until([] { return false; }, 0.025));
  convert(module, 100);
  const WallTime last = WallClock::now();
  std::vector<Scan> scans = read_until(*device, 224);
  ASSERT_EQ(scans.size(), 200U);
  EXPECT_EQ(scans[99].index, 99);
  EXPECT_EQ(scans[100].index, 125);
  EXPECT_FALSE(scans[100].after_absence);
  EXPECT_EQ(of(*device, DeviceCounter::kPacketsMissing), 25);

  ip("link set " + node_side() + " down");
  ASSERT_TRUE(wait_until([&] { return of(*device, DeviceCounter::kGone) == 1; }, 10));
  ip("link set " + node_side() + " up");
  ASSERT_TRUE(wait_until([&] { return of(*device, DeviceCounter::kReturned) == 1; }, 10));
  ASSERT_FALSE(wait_until([] { return false; }, 0.3));  // more than the 256 that a byte can count
  // The module went on all the time.
  const auto absent = std::chrono::duration_cast<std::chrono::milliseconds>(WallClock::now() - last).count();
  ASSERT_GT(absent, 300);
  module.skip(static_cast<std::uint32_t>(absent));
  convert(module, 100);
  scans = read_until(*device, 225 + absent + 99);
  ASSERT_EQ(scans.size(), 100U);
  EXPECT_TRUE(scans[0].after_absence);
  EXPECT_FALSE(scans[1].after_absence);
  EXPECT_EQ(scans[0].index, 225 + absent);  // 8 bits of number count it with the help of the stamps
  EXPECT_EQ(of(*device, DeviceCounter::kPacketsMissing), 25) << "what was not there is not missing packets";
  const std::vector<std::string> sentences = said(*device);
  for (const char* words :
       {": was unplugged or went down (1 time by now)", ": is there again (1 time by now)"})
    EXPECT_EQ(std::ranges::count(sentences, "can:" + node_side() + words), 1) << words;
}

/// A text of a device, and its source.
struct Warning {
  std::string text;
  std::thread::id thread;
};

TEST_P(AccelerometerTest, AModuleThatFallsSilentIsGoneUntilItsNextScan) {
  const auto device = open_module();
  std::int64_t index = 0;
  {
    AccelerometerModule module(module_side(), is_fd());
    convert(module, 100);
    index = read_until(*device, 99).back().index;
    EXPECT_TRUE(read_until(*device, INT64_MAX, std::chrono::milliseconds(1'500)).empty());
    EXPECT_EQ(of(*device, DeviceCounter::kGone), 0);
    EXPECT_TRUE(read_until(*device, INT64_MAX, std::chrono::milliseconds(2'500)).empty());
  }
  EXPECT_EQ(of(*device, DeviceCounter::kGone), 1);
  EXPECT_EQ(of(*device, DeviceCounter::kReturned), 0);
  AccelerometerModule again(module_side(), is_fd());
  convert(again, 100);
  const std::vector<Scan> scans = read_until(*device, INT64_MAX, std::chrono::milliseconds(500));
  ASSERT_EQ(scans.size(), 100U);
  EXPECT_TRUE(scans[0].after_absence);
  EXPECT_GT(scans[0].index, index + 4'000);
  EXPECT_EQ(of(*device, DeviceCounter::kGone), 1);
  EXPECT_EQ(of(*device, DeviceCounter::kReturned), 1);
  EXPECT_EQ(of(*device, DeviceCounter::kPacketsMissing), 0);
}

TEST_P(AccelerometerTest, SaysOnceOfEachSilenceButNotFromTheThreadThatReads) {
  std::mutex mutex;
  std::vector<Warning> warnings;
  const auto device = open_module([&](const std::string& text) {
    const std::lock_guard lock(mutex);
    warnings.push_back({text, std::this_thread::get_id()});
  });
  const std::string silence = "can:" + node_side() + ": no scan of the accelerometer module comes";
  const auto said = [&] {
    const std::lock_guard lock(mutex);
    return std::ranges::count_if(warnings, [&](const Warning& w) { return w.text.starts_with(silence); });
  };
  AccelerometerModule module(module_side(), is_fd());
  for (int silences = 1; silences <= 2; ++silences) {
    EXPECT_TRUE(read_until(*device, INT64_MAX, std::chrono::milliseconds(2'500)).empty());
    EXPECT_TRUE(wait_until([&] { return said() == silences; }, 5));
    EXPECT_TRUE(read_until(*device, INT64_MAX, std::chrono::milliseconds(2'500)).empty());
    EXPECT_EQ(said(), silences);
    convert(module, 1);
    EXPECT_EQ(read_until(*device, 0).size(), 1U);
  }
  for (const Warning& warning : warnings) EXPECT_NE(warning.thread, std::this_thread::get_id());
}

INSTANTIATE_TEST_SUITE_P(Forms, AccelerometerTest, testing::Values(true, false),
                         [](const auto& form) { return form.param ? "CanFd" : "ClassicCan"; });

}  // namespace
}  // namespace roadbalance

#include "firmware/node.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <numbers>
#include <set>
#include <thread>

#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/process/parallel.hpp"
#include "common/test/bus_url.hpp"
#include "firmware/test/little_recorder.hpp"
#include "firmware/test/scripted_front_end.hpp"
#include "firmware/test/vehicle.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

constexpr std::int32_t kNode = 3;
constexpr double kRate_hz = 2000.0;

TEST(RunNode, DeliversEveryScanOnceOverALossyBusAndEndsWhenAllIsDurable) {
  const std::string url = test::bus_url();
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  const sim::PulseTrain train{.angle_rad = [](double t) { return 2 * std::numbers::pi * 18.0 * t; }};
  test::ScriptedFrontEnd device(test::marked_scans(0, 4007, kRate_hz), train.edges(0.0, 2.1));
  test::LittleRecorder owner(url, kNode);
  Parallel processes;
  processes.run([&](std::stop_token stop) { owner.run(stop); });
  processes.run([&](std::stop_token stop) {
    run_node(stop, vehicle, vehicle.node[0], device, {.bus_url = url, .ring_bytes = std::size_t{1} << 20});
  });
  processes.wait();

  std::int64_t next = 0;
  for (const auto& [sequence, block] : owner.blocks) {
    if (block.kind != BlockKind::kScan) continue;
    EXPECT_EQ(block.header.first_scan, next);
    next += block.header.scans;
    const ScanBlock scan = decode_scan(block);
    for (std::int64_t row = 0; row < scan.header.scans; ++row)
      ASSERT_EQ(scan.counts[static_cast<std::size_t>(row)][5],
                test::marked_counts(scan.header.first_scan + row, 5));
  }
  EXPECT_EQ(next, 4007);
  EXPECT_EQ(owner.replies.at(2).result, CommandError::kNone);
  EXPECT_EQ(owner.last.scans_sampled, 4007);
  EXPECT_EQ(owner.last.scans_missing, 0);
  EXPECT_GE(owner.last.blocks_repaired, owner.end / 3);
  EXPECT_EQ(owner.last.state, NodeState::kEnded);
}

TEST(RunNode, DeliversSignalsAndSaysWhatItsDevicesSuffer) {
  const std::string url = test::bus_url();
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  DeviceReport can("can:can0"), usb("usb:");
  test::ScriptedFrontEnd device(test::marked_scans(0, 4000, kRate_hz), {});
  for (int k = 0; k < 300; ++k)
    device.signals.push_back({node_time_from_ns(k * 6'000'000), static_cast<std::uint16_t>(k % 3), 0.5 * k});
  device.devices = {&can, &usb};
  can.count(DeviceCounter::kGone);
  can.count(DeviceCounter::kBusErrors, 2);
  usb.count(DeviceCounter::kBusErrors, 3);
  std::mutex mutex;
  std::set<std::string> warned;
  const auto warn = [&](const std::string& sentence) {
    const std::lock_guard lock(mutex);
    warned.insert(sentence);
  };
  test::LittleRecorder owner(url, kNode);
  Parallel processes;
  processes.run([&](std::stop_token stop) { owner.run(stop); });
  processes.run([&](std::stop_token stop) {
    run_node(stop, vehicle, vehicle.node[0], device,
             {.bus_url = url, .ring_bytes = std::size_t{1} << 20, .warn = warn});
  });
  processes.wait();

  int next = 0;
  for (const auto& [sequence, block] : owner.blocks) {
    if (block.kind != BlockKind::kSignal) continue;
    for (const SignalSample& sample : decode_signal(block).unpack()) {
      EXPECT_EQ(to_ns(sample.time), next * 6'000'000);
      EXPECT_EQ(sample.signal, next % 3);
      EXPECT_EQ(sample.value, 0.5 * next);
      ++next;
    }
  }
  EXPECT_EQ(next, 300);
  std::array<std::int64_t, kDeviceCounters> sums{};
  sums[static_cast<std::size_t>(DeviceCounter::kGone)] = 1;
  sums[static_cast<std::size_t>(DeviceCounter::kBusErrors)] = 5;
  EXPECT_EQ(owner.last.device_counts, sums);
  EXPECT_EQ(warned, (std::set<std::string>{"can:can0: was unplugged or went down (1 time by now)",
                                           "can:can0: the controller saw errors on the bus (2 times by now)",
                                           "usb:: the controller saw errors on the bus (3 times by now)"}));
}

TEST(RunNode, SaysWhichEncoderHadTurnsWithoutTheirTeeth) {
  const std::string url = test::bus_url();
  auto vehicle = test::one_node_vehicle(kRate_hz);
  for (auto& wheel : vehicle.wheel) wheel.encoder.zero_mark = true;
  const sim::PulseTrain train{.angle_rad = [](double t) { return 2 * std::numbers::pi * 18.0 * t; },
                              .line = 1};
  std::vector<Edge> edges = train.edges(0.0, 2.1);
  // As if the kernel had taken two edges as one, without a sign.
  edges.erase(edges.begin() + 18 * 97 + 40);
  test::ScriptedFrontEnd device(test::marked_scans(0, 4007, kRate_hz), std::move(edges));
  std::mutex mutex;
  std::vector<std::string> warned;
  const auto warn = [&](const std::string& sentence) {
    const std::lock_guard lock(mutex);
    warned.push_back(sentence);
  };
  test::LittleRecorder owner(url, kNode);
  Parallel processes;
  processes.run([&](std::stop_token stop) { owner.run(stop); });
  processes.run([&](std::stop_token stop) {
    run_node(stop, vehicle, vehicle.node[0], device,
             {.bus_url = url, .ring_bytes = std::size_t{1} << 20, .warn = warn});
  });
  processes.wait();
  EXPECT_EQ(owner.last.encoder_faults, (std::array<std::int64_t, 2>{0, 1}));
  EXPECT_EQ(owner.last.device_counts[static_cast<std::size_t>(DeviceCounter::kFaultyTurns)], 1);
  EXPECT_EQ(warned,
            std::vector<std::string>{"encoder of line 1: turns came without exactly their teeth; they "
                                     "are flagged (1 time by now)"});
}

/// A device that measures nothing yet, and may hang.
class QuietFrontEnd final : public FrontEnd {
 public:
  std::atomic<bool> hangs = false;
  Read read(std::span<Scan>, std::span<Edge>, std::span<SignalSample>) noexcept override {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    hangs.wait(true);
    return {};
  }
};

TEST(RunNode, ProvesItsLifeWhileItsDeviceIsRead) {
  const std::string url = test::bus_url();
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  Bus bus(url);
  int heartbeats = 0;
  bus.subscribe(heartbeat_channel(kNode), [&](std::string_view, auto) { ++heartbeats; });
  const auto hear = [&](int more) {
    for (const int until = heartbeats + more; heartbeats < until;)
      ASSERT_GT(bus.handle(std::chrono::seconds(5)), 0);
  };
  QuietFrontEnd device;
  std::atomic<int> proofs = 0;
  Parallel node;
  node.run([&](std::stop_token stop) {
    run_node(stop, vehicle, vehicle.node[0], device, {.bus_url = url, .on_alive = [&] { ++proofs; }});
  });
  while (proofs < 2 && !HasFatalFailure()) hear(1);
  device.hangs = true;
  hear(10);  // a second, in which what it did before may still be proven
  const int before = proofs;
  hear(20);
  EXPECT_EQ(proofs, before) << "what sends still turns, but that is not all";
  device.hangs = false;
  device.hangs.notify_all();
  while (proofs == before && !HasFatalFailure()) hear(1);
  node.request_stop();
  node.wait();
}

TEST(RunNode, NamesARingThatIsTooSmall) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::ScriptedFrontEnd device({}, {});
  try {
    run_node({}, vehicle, vehicle.node[0], device,
             {.bus_url = test::bus_url(), .ring_bytes = 32 * sizeof(SealedBlock)});
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("node axle needs at least"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace roadbalance

#include "firmware/acquire.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <numbers>
#include <thread>

#include "common/bus/codec.hpp"
#include "common/test/no_allocation.hpp"
#include "firmware/ring_sink.hpp"
#include "firmware/test/scripted_front_end.hpp"
#include "firmware/test/vehicle.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

constexpr double kRate_hz = 2000.0;

struct Node {
  explicit Node(std::size_t ring_bytes = Ring::kDefaultBytes)
      : vehicle(test::one_node_vehicle(kRate_hz)),
        ring(ring_bytes),
        sink(ring),
        packer(vehicle, vehicle.node[0], 5, sink, &preview) {}

  const VehicleConfig vehicle;
  Ring ring;
  RingSink sink;
  PreviewSlot preview;
  BlockPacker packer;
  AcquireLink link;
};

std::vector<Edge> turning(double seconds) {
  return sim::PulseTrain{.angle_rad = [](double t) { return 2 * std::numbers::pi * 18.0 * t; }}.edges(
      0.0, seconds);
}

TEST(Acquire, NeverAllocates) {
  Node node;
  test::ScriptedFrontEnd device(test::marked_scans(0, 20'000, kRate_hz), turning(10.0), 100);
  node.link.start_at = AcquireLink::kAtOnce;
  {
    const test::NoAllocation guard;
    acquire({}, device, node.packer, node.sink, node.link);
  }
  EXPECT_EQ(node.link.state.load(), NodeState::kEnded);
  EXPECT_EQ(node.link.scans_sampled.load(), 20'000);
  EXPECT_EQ(node.link.scans_missing.load(), 0);
}

TEST(Acquire, TakesNothingFromAWaitingDeviceBeforeItIsStarted) {
  Node node;
  test::ScriptedFrontEnd device(test::marked_scans(0, 100, kRate_hz), {});
  std::stop_source stop;
  std::thread process([&] { acquire(stop.get_token(), device, node.packer, node.sink, node.link); });
  stop.request_stop();
  process.join();
  std::array<Scan, 100> scans;
  std::array<Edge, 64> edges;
  EXPECT_EQ(device.read(scans, edges, {}).scans, 64U);  // a whole run of the script: none was taken
  EXPECT_EQ(node.ring.used(), 0);
}

TEST(Acquire, LosesNothingOfAWaitingDeviceToASmallRing) {
  Node node(256 * sizeof(SealedBlock));
  test::ScriptedFrontEnd device(test::marked_scans(0, 20'000, kRate_hz), turning(10.0), 250);
  node.link.start_at = AcquireLink::kAtOnce;
  std::thread process([&] { acquire({}, device, node.packer, node.sink, node.link); });
  // The other side frees what it has seen, as an uplink whose owner is quick.
  std::int64_t seen = 0, scans = 0;
  for (bool ended = false; !ended;) {
    if (node.ring.next() - 1 == seen) {
      std::this_thread::yield();
      continue;
    }
    const SealedBlock& block = node.ring.get(++seen);
    EXPECT_EQ(block.header.sequence, seen);
    EXPECT_NE(block.kind, BlockKind::kGap);
    if (block.kind == BlockKind::kScan) scans += block.header.scans;
    ended = block.kind == BlockKind::kEnd;
    node.ring.free_through(seen);
  }
  process.join();
  EXPECT_EQ(scans, 20'000);
}

/// A device that does not wait, with its own idea of when it ends.
class Impatient final : public FrontEnd {
 public:
  explicit Impatient(FrontEnd& inner) : inner_(inner) {}
  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample>) noexcept override {
    return inner_.read(scans, edges, {});
  }

 private:
  FrontEnd& inner_;
};

TEST(Acquire, OfAFullRingKeepsTheOldestAndTellsHowManyScansAreMissing) {
  Node node(256 * sizeof(SealedBlock));
  test::ScriptedFrontEnd scripted(test::marked_scans(0, 20'000, kRate_hz), {}, 250);
  Impatient device(scripted);
  node.link.start_at = AcquireLink::kAtOnce;
  std::stop_source stop;
  std::thread process([&] { acquire(stop.get_token(), device, node.packer, node.sink, node.link); });
  while (node.link.scans_sampled.load() < 20'000) std::this_thread::yield();
  node.ring.free_through(node.ring.next() - 1);  // the recorder is back: gap and end are written
  process.join();
  const SealedBlock& end = node.ring.get(node.ring.next() - 1);
  ASSERT_EQ(end.kind, BlockKind::kEnd);
  EXPECT_GT(decode_end(end).scans_missing, 20'000 - 256 * kScansPerBlock);
  EXPECT_EQ(decode_end(end).scans_missing, node.link.scans_missing.load());
  EXPECT_EQ(decode_end(end).header.first_scan, 20'000);
}

/// A device that gives nothing more, and does not report that it ended.
class FallsSilent final : public FrontEnd {
 public:
  explicit FallsSilent(FrontEnd& inner) : inner_(inner) {}
  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample>) noexcept override {
    Read read = inner_.read(scans, edges, {});
    if (read.status != ReadStatus::kEnd) return read;
    if (read.scans == 0) is_silent = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    read.status = ReadStatus::kOk;
    return read;
  }
  std::atomic<bool> is_silent = false;

 private:
  FrontEnd& inner_;
};

TEST(Acquire, EndsWhenToldToThoughItsDeviceHasFallenSilent) {
  Node node;
  test::ScriptedFrontEnd scripted(test::marked_scans(0, 4000, kRate_hz), turning(1.9), 10);
  FallsSilent device(scripted);
  node.link.start_at = AcquireLink::kAtOnce;
  std::thread process([&] { acquire({}, device, node.packer, node.sink, node.link); });
  while (!device.is_silent) std::this_thread::yield();
  EXPECT_LT(node.link.scans_sampled.load(), 4000) << "the last scans wait for edges";
  node.link.stop_at = AcquireLink::kAtOnce;
  process.join();
  const SealedBlock& end = node.ring.get(node.ring.next() - 1);
  ASSERT_EQ(end.kind, BlockKind::kEnd);
  EXPECT_EQ(decode_end(end).scans_sealed, 4000);
}

/// A device that runs by the machine's clock, from when it is made on.
class Clocked final : public FrontEnd {
 public:
  Read read(std::span<Scan> scans, std::span<Edge>, std::span<SignalSample>) noexcept override {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    Read read;
    for (; read.scans < scans.size() && at(next_) <= as_node_time(MachineClock::now()); ++next_)
      scans[read.scans++] = {.index = next_, .time = at(next_)};
    return read;
  }

 private:
  NodeTime at(std::int64_t scan) const { return begin_ + NodeClock::duration(scan * 500'000); }
  const NodeTime begin_ = as_node_time(MachineClock::now());
  std::int64_t next_ = 0;
};

TEST(Acquire, BeginsAndEndsAtInstantsByTheDevicesClock) {
  Node node;
  Clocked device;
  std::thread process([&] { acquire({}, device, node.packer, node.sink, node.link); });
  const WallTime start = WallClock::now() + std::chrono::milliseconds(500);
  const auto machine_at_start = std::chrono::milliseconds(500) + MachineClock::now().time_since_epoch();
  node.link.start_at = start;
  node.link.stop_at = start + std::chrono::milliseconds(200);
  process.join();
  const SealedBlock& end = node.ring.get(node.ring.next() - 1);
  ASSERT_EQ(end.kind, BlockKind::kEnd);
  EXPECT_NEAR(static_cast<double>(decode_end(end).scans_sealed), 400.0, 1.0);
  EXPECT_EQ(decode_end(end).scans_missing, 0);
  for (std::int64_t k = 1; k < node.ring.next(); ++k) {
    const SealedBlock& block = node.ring.get(k);
    if (block.kind != BlockKind::kScan) continue;
    // The clocks of the protocol and of the machine are read one behind the other here.
    EXPECT_NEAR(static_cast<double>(block.header.time_ns), static_cast<double>(machine_at_start.count()),
                5e6);
    break;
  }
}

TEST(Acquire, TellsWhyItsEpochEnded) {
  const auto cause = [](bool is_stopped, std::stop_token program) {
    Node node;
    test::ScriptedFrontEnd device(test::marked_scans(0, 200, kRate_hz), {}, 10);
    node.link.start_at = AcquireLink::kAtOnce;
    if (is_stopped) node.link.stop_at = AcquireLink::kAtOnce;
    acquire(program, device, node.packer, node.sink, node.link);
    return node.link.end_cause.load();
  };
  std::stop_source ended;
  ended.request_stop();
  EXPECT_EQ(cause(false, {}), AbsenceCause::kSourceOver);
  EXPECT_EQ(cause(true, {}), AbsenceCause::kStopped);
  EXPECT_EQ(cause(false, ended.get_token()), AbsenceCause::kProgramEnded);
}

TEST(Acquire, EndsWhenToldToWithWhatItHas) {
  Node node;
  test::ScriptedFrontEnd device(test::marked_scans(0, 4000, kRate_hz), {}, 10);
  node.link.start_at = AcquireLink::kAtOnce;
  node.link.stop_at =
      AcquireLink::kAtOnce;  // started and stopped before the first scan: an epoch without scans
  acquire({}, device, node.packer, node.sink, node.link);
  EXPECT_EQ(node.link.state.load(), NodeState::kEnded);
  const SealedBlock& end = node.ring.get(node.ring.next() - 1);
  ASSERT_EQ(end.kind, BlockKind::kEnd);
  EXPECT_EQ(decode_end(end).scans_sealed, 0);
}

}  // namespace
}  // namespace roadbalance

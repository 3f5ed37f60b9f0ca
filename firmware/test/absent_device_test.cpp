#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/bus/codec.hpp"
#include "firmware/acquire.hpp"
#include "firmware/block_packer.hpp"
#include "firmware/readout_clock.hpp"
#include "firmware/ring_sink.hpp"
#include "firmware/test/sealed_epoch.hpp"
#include "firmware/test/valve.hpp"

// A device that is not there at the start, or at the stop: no scan behind or before shows it.
namespace roadbalance {
namespace {

using test::kEpoch;
using test::kRate_hz;

std::int64_t time_at(double seconds) {
  return std::llround(seconds * 1e9);
}

/// A packer and the blocks of its epoch; a device that runs by the clock and is asked every 50 ms.
struct Clocked {
  /// Time passes to `until`, in seconds; the device gives its scans, or is not there.
  void pass(double until_s, bool is_there = true) {
    for (; now < std::llround(until_s * kRate_hz); now += 100) {
      const auto scans = test::marked_scans(now, now + 100, kRate_hz);
      if (is_there) given.assign(scans.begin(), scans.end());
      if (is_there && returns) given[0].after_absence = true;
      returns = !is_there && any;
      any = any || is_there;
      packer.add(is_there ? std::span<const Scan>(given) : std::span<const Scan>(), {}, false);
      packer.asked(scans.back().time);
    }
  }
  /// The gaps of the epoch, which has to be sound: as check_epoch(), with channels of scan `first` on.
  std::vector<GapBlock> end() {
    packer.device_ended();
    EXPECT_TRUE(packer.finish());
    std::vector<GapBlock> gaps;
    std::int64_t next = 0;
    for (const auto& block : valve.blocks) {
      if (block.kind == BlockKind::kGap) gaps.push_back(decode_gap(block));
      if (block.kind != BlockKind::kScan && block.kind != BlockKind::kGap) continue;
      EXPECT_EQ(block.header.first_scan, next);
      next += block.header.scans;
    }
    const EndBlock last = decode_end(valve.blocks.back());
    EXPECT_EQ(last.scans_sealed + last.scans_missing, next);
    EXPECT_EQ(last.header.first_scan, next);
    return gaps;
  }
  const VehicleConfig vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  BlockPacker packer{vehicle, vehicle.node[0], kEpoch, valve, nullptr};
  std::int64_t now = 0;  ///< in scans
  bool any = false, returns = false;
  std::vector<Scan> given;
};

// The device was asked a scan's period before or behind where its next one would have been.
constexpr std::int64_t kOne = 1;

TEST(AbsentDevice, DeclaresTheScansOfADeviceThatIsNotThereAtTheStop) {
  Clocked node;
  node.pass(0.5);
  node.packer.start();
  node.pass(3.0);
  node.pass(10.0, false);
  node.packer.stop();
  node.pass(12.0, false);
  const auto gaps = node.end();
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_EQ(gaps[0].cause, GapCause::kDeviceGone);
  EXPECT_EQ(gaps[0].header.first_scan, 5000);
  EXPECT_NEAR(static_cast<double>(gaps[0].header.scans), 14'000, kOne);
  EXPECT_EQ(gaps[0].header.time_ns, time_at(3.0));
  EXPECT_EQ(node.packer.counts().scans_missing, gaps[0].header.scans);
  EXPECT_NEAR(static_cast<double>(decode_end(node.valve.blocks.back()).header.time_ns),
              static_cast<double>(time_at(10.0)), 1e6);
}

TEST(AbsentDevice, DeclaresTheScansOfADeviceThatIsNotThereAtTheStart) {
  for (const bool was_there_before : {false, true}) {
    Clocked node;
    node.pass(0.5, was_there_before);
    node.pass(4.0, false);
    node.packer.start();
    node.pass(9.0, false);
    node.pass(10.0);
    node.packer.stop();
    const auto gaps = node.end();
    ASSERT_EQ(gaps.size(), 1U);
    EXPECT_EQ(gaps[0].cause, GapCause::kDeviceGone);
    EXPECT_EQ(gaps[0].header.first_scan, 0);
    EXPECT_NEAR(static_cast<double>(gaps[0].header.scans), 10'000, kOne);
    EXPECT_NEAR(static_cast<double>(gaps[0].header.time_ns), static_cast<double>(time_at(4.0)), 1e6);
    EXPECT_EQ(decode_end(node.valve.blocks.back()).scans_sealed, 2000);
  }
}

TEST(AbsentDevice, DeclaresAllScansOfADeviceThatIsNeverThere) {
  Clocked node;
  node.pass(4.0, false);
  node.packer.start();
  node.pass(9.0, false);
  node.valve.open = false;
  node.packer.stop();
  node.packer.device_ended();
  EXPECT_FALSE(node.packer.finish());
  node.valve.open = true;
  const auto gaps = node.end();
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_EQ(gaps[0].header.first_scan, 0);
  EXPECT_NEAR(static_cast<double>(gaps[0].header.scans), 10'000, kOne);
  EXPECT_EQ(decode_end(node.valve.blocks.back()).scans_sealed, 0);
}

TEST(AbsentDevice, TakesNoMomentForAnAbsence) {
  Clocked node;
  node.pass(1.0, false);
  node.packer.start();
  node.pass(1.9, false);  // it begins
  node.pass(5.0);
  node.pass(5.9, false);  // scans are on their way
  node.packer.stop();
  EXPECT_EQ(node.end().size(), 0U);
  EXPECT_EQ(node.packer.counts().scans_sampled, 6200);
}

TEST(AbsentDevice, TakesNoTimeInWhichNobodyAskedForAnAbsence) {
  Clocked node;
  node.packer.start();
  node.pass(5.0);
  node.packer.add({}, {}, false);
  node.packer.asked(node_time_from_ns(time_at(60.0)));  // the process was not scheduled
  node.packer.stop();
  EXPECT_EQ(node.end().size(), 0U);
}

/// Runs by a clock of its own, which each read moves, until it is stopped after 10 s; is there for some of
/// it.
class There final : public FrontEnd {
 public:
  /// @param from, to  in scans, there; it is not to give anything before `begins`
  There(AcquireLink& link, std::int64_t from, std::int64_t to, std::int64_t begins)
      : link_(link), from_(from), to_(to), begins_(begins) {}
  Read read(std::span<Scan> scans, std::span<Edge>, std::span<SignalSample>) noexcept override {
    if (now_ == 20'000) link_.stop_at = AcquireLink::kAtOnce;
    const std::int64_t from = now_;
    now_ += 100;
    if (from < from_ || from >= to_) return {};
    for (std::int64_t i = from; i < now_; ++i) {
      Scan& scan = scans[static_cast<std::size_t>(i - from)];
      scan = {.index = i, .time = node_time_from_ns(i * 500'000)};
    }
    return {.scans = 100};
  }
  NodeTime node_time(MachineTime) const noexcept override { return node_time_from_ns(now_ * 500'000); }
  NodeTime begins() const noexcept override { return node_time_from_ns(begins_ * 500'000); }

 private:
  AcquireLink& link_;
  const std::int64_t from_, to_, begins_;
  std::int64_t now_ = 0;  ///< in scans
};

/// The kept scans, and the missing ones.
std::pair<std::int64_t, std::int64_t> acquired(std::int64_t from, std::int64_t to, std::int64_t begins) {
  const VehicleConfig vehicle = test::one_node_vehicle(kRate_hz);
  Ring ring(Ring::kDefaultBytes);
  RingSink sink(ring);
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, sink, nullptr);
  AcquireLink link;
  There device(link, from, to, begins);
  link.start_at = AcquireLink::kAtOnce;
  ConversionTimes times(device, kRate_hz);  // as in a node
  acquire({}, times, packer, sink, link);
  return {link.scans_sampled.load() - link.scans_missing.load(), link.scans_missing.load()};
}

TEST(AbsentDevice, IsAskedByAcquireAndMissed) {
  const auto [early, early_missing] = acquired(0, 6000, 0);
  EXPECT_EQ(early, 6000);
  EXPECT_NEAR(static_cast<double>(early_missing), 14'000, kOne);
  const auto [late, late_missing] = acquired(6000, 30'000, 0);
  EXPECT_EQ(late, 14'000);
  EXPECT_NEAR(static_cast<double>(late_missing), 6000, kOne);
}

// As a drive of the simulated car from a later instant on.
TEST(AbsentDevice, IsNotMissedBeforeItBegins) {
  EXPECT_EQ(acquired(6000, 30'000, 6000), std::pair(std::int64_t{14'000}, std::int64_t{0}));
}

}  // namespace
}  // namespace roadbalance

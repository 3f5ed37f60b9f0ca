#include "firmware/sleep_gaps.hpp"

#include <gtest/gtest.h>

#include "common/bus/codec.hpp"
#include "firmware/block_packer.hpp"
#include "firmware/test/sealed_epoch.hpp"
#include "firmware/test/valve.hpp"

namespace roadbalance {
namespace {

using test::kEpoch;
using test::kRate_hz;
using namespace std::chrono_literals;

/// Samples while the computer is awake; numbers its scans one by one or by its clock, which runs on or does
/// not.
class Converter final : public FrontEnd {
 public:
  bool counts_by_time = false;
  NodeClock::duration now{};  ///< its clock
  NodeClock::duration jumped{};

  Read read(std::span<Scan> scans, std::span<Edge>, std::span<SignalSample>) noexcept override {
    constexpr std::size_t kRun = 20;
    constexpr NodeClock::duration kPeriod = 500us;
    for (std::size_t k = 0; k < kRun; ++k, ++converted_, now += kPeriod) {
      scans[k] = {.index = counts_by_time ? now / kPeriod : converted_, .time = NodeTime(now)};
      if (const auto at = sleeps_at_; at && converted_ + 1 == *at) {
        now += jumped;
        sleeps_at_.reset();
      }
    }
    return {.scans = kRun};
  }
  /// Behind so many more scans.
  void sleep_in(std::int64_t scans) { sleeps_at_ = converted_ + scans; }

 private:
  std::int64_t converted_ = 0;
  std::optional<std::int64_t> sleeps_at_;
};

struct Node {
  Node() { packer.start(); }
  void read(int times) {
    std::array<Scan, 64> scans;
    std::array<Edge, 64> edges;
    for (; times > 0; --times) {
      const Read read = device.read(scans, edges, {});
      packer.add(std::span(scans).first(read.scans), {}, false);
    }
  }
  std::vector<GapBlock> end() {
    packer.device_ended();
    EXPECT_TRUE(packer.finish());
    std::vector<GapBlock> gaps;
    for (const SealedBlock& block : valve.blocks)
      if (block.kind == BlockKind::kGap) gaps.push_back(decode_gap(block));
    return gaps;
  }

  MachineClock::duration slept = 3h;  // before it began
  Converter converter;
  SleepGaps device{converter, kRate_hz, [this] { return slept; }};
  const VehicleConfig vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  BlockPacker packer{vehicle, vehicle.node[0], kEpoch, valve, nullptr};
};

TEST(SleepGaps, AreAsLongAsTheSleepAndBehindTheScansThatWereWaiting) {
  for (const bool by_time : {false, true})
    for (const MachineClock::duration length :
         {MachineClock::duration(1s), MachineClock::duration(60s + 123ms), MachineClock::duration(9h)}) {
      Node node;
      node.converter.counts_by_time = by_time;
      node.read(10);
      node.slept += length;
      node.converter.jumped = length;
      node.converter.sleep_in(33);  // so many were converted before it, and are read behind it
      node.read(20);
      const auto gaps = node.end();
      ASSERT_EQ(gaps.size(), 1u);
      EXPECT_EQ(gaps[0].cause, GapCause::kSlept);
      EXPECT_EQ(gaps[0].header.first_scan, 233);
      EXPECT_EQ(gaps[0].header.scans, length / 500us);
      EXPECT_EQ(gaps[0].header.time_ns, 233 * 500'000);
    }
}

TEST(SleepGaps, AreNotOfADeviceWhoseClockSleepsToo) {
  Node node;
  node.read(10);
  node.slept += 60s;
  node.read(2000);  // 20 s: nobody waits for a jump any more
  node.converter.jumped = 40s;
  node.converter.sleep_in(5);
  node.read(10);
  EXPECT_TRUE(node.end().empty())
      << "it numbers its scans one by one: an unexplained jump of its clock is none";
}

TEST(SleepGaps, AreTwoOfTwoSleeps) {
  Node node;
  node.read(5);
  for (int k = 0; k < 2; ++k) {
    node.slept += 10s;
    node.converter.jumped = 10s;
    node.converter.sleep_in(1);
    node.read(5);
  }
  const auto gaps = node.end();
  ASSERT_EQ(gaps.size(), 2u);
  EXPECT_EQ(gaps[0].header.first_scan, 101);
  EXPECT_EQ(gaps[1].header.first_scan, 101 + 20'000 + 100);
  for (const GapBlock& gap : gaps) EXPECT_EQ(gap.header.scans, 20'000);
}

}  // namespace
}  // namespace roadbalance

// A wheel whose teeth are counted on the car's bus and whose zero mark is on a line, through the node.
#include "firmware/counter_encoder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <memory>
#include <numbers>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/test/no_allocation.hpp"
#include "firmware/acquire.hpp"
#include "firmware/epoch_packer.hpp"
#include "firmware/ring_sink.hpp"
#include "firmware/test/butterworth.hpp"
#include "firmware/test/scripted_front_end.hpp"
#include "firmware/test/vehicle.hpp"
#include "sim/counter_messages.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;
constexpr double kDegree = pi / 180.0, kPitch_deg = 360.0 / 96.0;
constexpr double kRate_hz = 2000.0, kSeconds = 24.0;

/// 12 to 18 turns a second within 10 s, and back.
double wheel_rad(double t) {
  return 2 * pi * (15.0 * t - 3.0 * 10.0 / pi * std::sin(pi * t / 10.0));
}
double turns_hz(double t) {
  return 15.0 - 3.0 * std::cos(pi * t / 10.0);
}

struct JudgedBlock {
  double start_s;
  bool is_known, is_uncertain;
  double most_deg;  ///< that a row is off
};
struct Judged {
  int blocks = 0, unknown = 0;
  double rms_deg = 0.0, mean_deg = 0.0;
  std::vector<JudgedBlock> each;

  /// Blocks from [from, to) of which that is so.
  template <typename Is>
  std::ptrdiff_t count(double from_s, double to_s, Is is) const {
    return std::ranges::count_if(each, [&](const JudgedBlock& block) {
      return block.start_s >= from_s && block.start_s < to_s && is(block);
    });
  }
};
constexpr auto kIsClean = [](const JudgedBlock& block) { return block.is_known && !block.is_uncertain; };

class CounterEncoderInNode : public testing::Test {
 protected:
  VehicleConfig vehicle_ = test::one_node_vehicle(kRate_hz);
  sim::CounterMessages messages_{.angle_rad = wheel_rad, .jitter_s = 0.0005};
  NodeTime late_from_{NodeTime::max()};  ///< the first mark from then on comes 20 ms late

  void SetUp() override {
    SignalConfig counter{"fl_pulses", "ABS", "FL", SignalQuantity::kPulseCounter, "front_left"};
    counter.latency = {.mean_s = 0.010, .mean_sigma_s = 0.0, .jitter_s = 0.0005};
    CanConfig can;
    can.signal = {counter};
    vehicle_.node[0].wiring.can = {can};
    vehicle_.wheel[0].encoder.counter = "fl_pulses";
    vehicle_.wheel[0].encoder.datum_rad = 0.4;
    vehicle_.wheel[1].node.clear();
  }

  std::unique_ptr<FrontEnd> bus_and_line() const {
    std::vector<Edge> marks;
    for (const Edge& edge : sim::PulseTrain{.angle_rad = wheel_rad, .teeth = 4}.edges(0.0, kSeconds))
      if (edge.kind == EdgeKind::kZeroMark) marks.push_back(edge);
    if (const auto late = std::ranges::lower_bound(marks, late_from_, {}, &Edge::time); late != marks.end())
      late->time += NodeClock::duration(20'000'000);
    auto device = std::make_unique<test::ScriptedFrontEnd>(
        test::marked_scans(0, static_cast<int>(kSeconds * kRate_hz), kRate_hz), std::move(marks), 20);
    device->signals = messages_.samples(0.0, kSeconds);
    return device;
  }

  /// The node's references against the wheel.
  Judged drive(double from_s) {
    const auto device = bus_and_line();
    Judged judged;
    int rows = 0;
    pack_epoch(*device, vehicle_, vehicle_.node[0], 1, [&](const SealedBlock& sealed) {
      if (sealed.kind != BlockKind::kScan) return;
      const ScanBlock block = decode_scan(sealed);
      const double start = 1e-9 * static_cast<double>(block.header.time_ns);
      if (start < from_s || start > kSeconds - 0.5) return;
      ++judged.blocks;
      JudgedBlock& this_one =
          judged.each.emplace_back(JudgedBlock{.start_s = start,
                                               .is_known = (block.quality & kQualityNoReference0) == 0,
                                               .is_uncertain = (block.quality & kQualityUncertainAngle0) != 0,
                                               .most_deg = 0.0});
      if (!this_one.is_known) {
        ++judged.unknown;
        return;
      }
      for (std::size_t row = 0; row < kScansPerBlock; ++row) {
        const double t = start + static_cast<double>(row) / kRate_hz;
        const Complex found(block.counts[row][kAccelerations + 1], block.counts[row][kAccelerations]);
        const Complex truth =
            std::polar(1.0, wheel_rad(t) + 0.4) * test::response(vehicle_.filter, turns_hz(t));
        const double off = std::arg(found / truth) / kDegree;
        judged.rms_deg += off * off;
        judged.mean_deg += off;
        this_one.most_deg = std::max(this_one.most_deg, std::abs(off));
        ++rows;
      }
    });
    judged.rms_deg = std::sqrt(judged.rms_deg / std::max(rows, 1));
    judged.mean_deg /= std::max(rows, 1);
    return judged;
  }
};

TEST_F(CounterEncoderInNode, GivesTheWheelsAngleWithinTheBlocksWait) {
  for (const double rate_hz : {100.0, 50.0, 20.0}) {
    messages_.rate_hz = rate_hz;
    const Judged judged = drive(3.0);
    std::printf("%3.0f Hz: %.2f degrees rms, %+.2f mean, %d of %d blocks unknown\n", rate_hz, judged.rms_deg,
                judged.mean_deg, judged.unknown, judged.blocks);
    EXPECT_GT(judged.blocks, 2000);
    EXPECT_EQ(judged.unknown, 0);
    // A message is off by the rounding and by 0.5 ms of 15 turns a second: 0.29 and 0.72 pitches; a quadratic
    // through nine of them, in their middle, by 0.505 of that.
    const double message_deg = kPitch_deg * std::hypot(1.0 / std::sqrt(12.0), 0.0005 * 15.0 * 96.0);
    EXPECT_NEAR(judged.rms_deg, 0.505 * message_deg, 0.1 * 0.505 * message_deg) << rate_hz;
    EXPECT_LT(std::abs(judged.mean_deg), 0.15 * message_deg) << "what the marks leave";
  }
}

TEST_F(CounterEncoderInNode, HasNoAngleWhereMessagesComeTooSeldomOrMarksAreMissing) {
  messages_.rate_hz = 5.0;  // the next one comes when the block has gone
  const Judged seldom = drive(3.0);
  EXPECT_GT(seldom.unknown, seldom.blocks / 3);
  messages_.rate_hz = 50.0;
  vehicle_.wheel[0].encoder.zero_mark = false;
  const Judged unmarked = drive(3.0);
  EXPECT_EQ(unmarked.unknown, unmarked.blocks) << "a count is no angle";
}

TEST_F(CounterEncoderInNode, FlagsOrWithdrawsAnAngleThatTheMarksContradict) {
  constexpr double kLost_s = 10.0;
  messages_.jitter_s = 0.0;
  messages_.lost_counts = [](double t) { return t > kLost_s ? 5.0 : 0.0; };  // 18.75 degrees
  const Judged judged = drive(3.0);
  const auto is_wrong = [](const JudgedBlock& block) { return kIsClean(block) && block.most_deg > 9.0; };
  // A block is sealed without the messages that come later than 0.1 s, and a quadratic through nine of them
  // is no step; then the next mark is 1/18 s away, and four messages stand behind it 80 ms later.
  std::printf("clean but wrong: %td blocks before the loss is known, %td after it; none known of %td\n",
              judged.count(kLost_s - 0.1, kLost_s + 0.15, is_wrong),
              judged.count(kLost_s + 0.15, kSeconds, is_wrong),
              judged.count(3.0, kSeconds, [](const JudgedBlock& block) { return !block.is_known; }));
  EXPECT_EQ(judged.count(3.0, kLost_s - 0.1, is_wrong), 0);
  EXPECT_EQ(judged.count(kLost_s + 0.15, kSeconds, is_wrong), 0);
  EXPECT_EQ(judged.count(kLost_s + 0.15, kLost_s + 0.4, kIsClean), 0) << "nothing is claimed";
  // Eight marks later the new place is known: 0.45 s, and what a block waits.
  EXPECT_EQ(judged.count(kLost_s + 0.7, kSeconds, kIsClean),
            judged.count(kLost_s + 0.7, kSeconds, [](const JudgedBlock&) { return true; }));
}

TEST_F(CounterEncoderInNode, CountsBreaksOfTheCountApartFromFaultyTurns) {
  messages_.jitter_s = 0.0;
  messages_.lost_counts = [](double t) { return t > 10.0 ? 5.0 : 0.0; };
  const auto device = bus_and_line();
  Ring ring;
  RingSink sink(ring);
  BlockPacker packer(vehicle_, vehicle_.node[0], 1, sink, nullptr);
  AcquireLink link;
  link.start_at = AcquireLink::kAtOnce;
  acquire({}, *device, packer, sink, link);
  const DeviceReport& said = link.encoder[0];
  EXPECT_EQ(said.of(DeviceCounter::kCountBroken), 1);
  // The place moved once as many agreed; one that the loss smears may lie where they do not.
  EXPECT_NEAR(static_cast<double>(said.of(DeviceCounter::kMarksElsewhere)), CounterAngle::kSettled, 2.0);
  EXPECT_EQ(said.of(DeviceCounter::kFaultyTurns), 0);
  for (std::size_t k = 0; k < kDeviceCounters; ++k)
    EXPECT_EQ(link.encoder[1].of(static_cast<DeviceCounter>(k)), 0) << "no wheel is there";
}

TEST_F(CounterEncoderInNode, OnlyDoubtsItsAngleForATurnWhereOneMarkIsLate) {
  messages_.jitter_s = 0.0;
  late_from_ = node_time_from_ns(12'000'000'000);
  const Judged judged = drive(3.0);
  EXPECT_EQ(judged.unknown, 0);
  const auto is_uncertain = [](const JudgedBlock& block) { return block.is_uncertain; };
  // 17.7 turns a second: the next mark is 36 ms behind the late one, in messages of 20 ms.
  EXPECT_NEAR(static_cast<double>(judged.count(11.9, 12.3, is_uncertain)), 3.6, 2.0);
  EXPECT_EQ(judged.count(3.0, 11.9, is_uncertain) + judged.count(12.3, kSeconds, is_uncertain), 0);
}

TEST_F(CounterEncoderInNode, HasNoneFromABreakOfTheCountToTheNextMark) {
  const auto samples = messages_.samples(0.0, 8.0);
  CounterEncoder encoder(vehicle_.wheel[0].encoder, *vehicle_.node[0].wiring.signal(0));
  std::array<double, 4> angle;
  int known_before = 0, known_after = 0;
  double next_turn = 1.0;
  for (const SignalSample& sample : samples) {
    const double t = 1e-9 * static_cast<double>(to_ns(sample.time));
    if (t > 4.0 && t < 6.0) continue;  // 1024 pulses pass in 0.7 s: how many turns these were is unknown
    for (; t < 4.0 && wheel_rad(t) > 2 * pi * next_turn; next_turn += 1.0) {
      double at = t;  // Newton
      for (int k = 0; k < 20; ++k) at -= (wheel_rad(at) - 2 * pi * next_turn) / (2 * pi * turns_hz(at));
      encoder.add(node_time_from_ns(std::llround(1e9 * at)), EdgeKind::kZeroMark);
    }
    encoder.add(sample.time, sample.value);
    const bool known = encoder.angles(sample.time - NodeClock::duration(60'000'000), 5e5, angle);
    (t < 4.0 ? known_before : known_after) += known;
  }
  EXPECT_GT(known_before, 150);
  EXPECT_EQ(known_after, 0);
  EXPECT_EQ(encoder.breaks(), 1);
}

TEST_F(CounterEncoderInNode, NeverAllocates) {
  CounterEncoder encoder(vehicle_.wheel[0].encoder, *vehicle_.node[0].wiring.signal(0));
  const auto samples = messages_.samples(0.0, 2.0);
  std::vector<Edge> marks;
  for (const Edge& edge : sim::PulseTrain{.angle_rad = wheel_rad, .teeth = 4}.edges(0.0, 2.0))
    if (edge.kind == EdgeKind::kZeroMark) marks.push_back(edge);
  std::array<double, 40> angle;
  int known = 0;
  std::size_t mark = 0;
  const test::NoAllocation guard;
  for (const SignalSample& sample : samples) {
    for (; mark < marks.size() && marks[mark].time <= sample.time; ++mark)
      encoder.add(marks[mark].time, EdgeKind::kZeroMark);
    encoder.add(sample.time, sample.value);
    known += encoder.angles(sample.time - NodeClock::duration(120'000'000), 5e5, angle);
  }
  EXPECT_GT(known, 50);
}

}  // namespace
}  // namespace roadbalance

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "hil_tests/players/usb_board/test/edge_judge.hpp"
#include "hil_tests/players/usb_board/test/usb_board_fixture.hpp"

namespace roadbalance {
namespace {

using test::Bench;
using test::kRateHz;
using test::StampedScan;
using test::TurningWheel;

constexpr std::int64_t kScans = 100'000;

/// Transducers of a thousand pulses, both tracks and the zero mark; one turns backward.
std::vector<TurningWheel> two_wheels(MachineTime begin) {
  return {{.line = 0, .begin = begin}, {.line = 1, .turns_hz = 7.3, .backward = true, .begin = begin}};
}

Bench bench_with(const std::vector<TurningWheel>& wheels) {
  Bench bench = test::numbered_bench("BENCH1", 30.0);
  bench.next_change = test::TurningWheels(wheels);
  return bench;
}

class UsbWheelsTest : public test::UsbBoardFixture {
 protected:
  UsbWheelsTest() : UsbWheelsTest(two_wheels(MachineClock::now())) {}
  explicit UsbWheelsTest(std::vector<TurningWheel> turning)
      : UsbBoardFixture(bench_with(turning)), wheels(std::move(turning)) {
    for (const TurningWheel& wheel : wheels)
      car.wheel[wheel.line].encoder = {.pulses_per_turn = wheel.teeth, .zero_mark = true, .quadrature = true};
    car.node[0].wiring.loop_back = true;
    car.node[0].channel[0].input_range_v = 5.0;  // the others: the widest there is
    car.node[0].channel[7].input_range_v = 1.25;
    car.filter = {.order = 6, .cutoff_hz = 1250.0};
    // Pages that are touched for the first time while the board runs would hold up the reader.
    scans.assign(2 * kScans, Scan{});
    edges.assign(500'000, Edge{});
    scans.clear();
    edges.clear();
  }
  /// Since the wheels began to turn.
  std::vector<StampedScan> stamped() {
    MachineTime first{}, last{};
    boards.with(0, [&](test::BenchBoard& board) {
      first = board.conversion_time(0);
      last = board.conversion_time(kScans);
    });
    const double period_s = 1e-9 * static_cast<double>((last - first).count()) / kScans;
    const double first_s = 1e-9 * static_cast<double>((first - wheels[0].begin).count());
    std::vector<StampedScan> all;
    for (const Scan& scan : scans)
      all.push_back({scan.time, first_s + static_cast<double>(scan.index) * period_s});
    return all;
  }
  /// Deviation of the references from sine and cosine of their wheel's angle, from the time they have locked.
  double worst_reference(const TurningWheel& wheel, const std::vector<StampedScan>& truth) const {
    double worst = 0.0;
    for (std::size_t k = 2 * static_cast<std::size_t>(kRateHz); k < scans.size(); ++k) {
      // The output of the D/A is read half a period later.
      const double turned = wheel.way_at(truth[k].true_s - 0.5 / kRateHz) - wheel.mark();
      const double angle = (wheel.backward ? -2.0 : 2.0) * std::numbers::pi * turned / wheel.teeth;
      const std::array<double, 2> expected{std::sin(angle), std::cos(angle)};
      for (std::size_t c = 0; c < 2; ++c)
        worst = std::max(
            worst, std::abs(scans[k].references[2 * wheel.line + c] / static_cast<double>(kFullScaleCounts) -
                            expected[c]));
    }
    return worst;
  }

  const std::vector<TurningWheel> wheels;
  std::vector<Scan> scans;
  std::vector<Edge> edges;
};

TEST_F(UsbWheelsTest, SixteenChannelsAtTenKilohertzAndTwoEncodersLoseNothingAndAreStampedTruly) {
  boards.plug();
  open({.scan = [&](const Scan& scan) { scans.push_back(scan); },
        .edge = [&](const Edge& edge) { edges.push_back(edge); }});
  ASSERT_TRUE(watch->more_scans(kScans));
  watch->end();
  EXPECT_GE(watch->scans(), kScans);
  EXPECT_EQ(watch->jumps().size(), 0u);
  EXPECT_EQ(watch->gaps().size(), 0u);
  EXPECT_EQ(watch->wrong_scans(), 0);  // counts and overload bits
  EXPECT_EQ(watch->end_block().scans_missing, 0);
  const auto overloads = std::ranges::count_if(scans, [](const Scan& scan) { return scan.overload != 0; });
  EXPECT_EQ(overloads, (scans.back().index + 1) / test::kOverloads);
  expect_only({});
  boards.with(0, [](const test::BenchBoard& board) {
    const board::Configuration& set_up = board.configuration();
    EXPECT_EQ(set_up.filter_order, 6);
    EXPECT_EQ(set_up.filter_corner_hz, 1250u);
    // As the board numbers them: 10, 5, 2.5 and 1.25 V.
    for (std::size_t k = 0; k < board::kInputChannels; ++k)
      EXPECT_EQ(set_up.range[k], k == 0 ? 1 : k == 7 ? 3 : 0) << k;
  });
  const std::vector<StampedScan> truth = stamped();
  // Half the difference of a question's two ways; the earliest packets alone are 40 to 60 us late.
  const double late_us =
      1e6 * (to_seconds(scans.back().time - as_node_time(wheels[0].begin)) - truth.back().true_s);
  EXPECT_NEAR(late_us, 0.0, 20.0);
  std::printf("%lld scans of 16 channels at %g Hz, none lost, %td overloads; stamps %.1f us late\n",
              static_cast<long long>(watch->scans()), kRateHz, overloads, late_us);
  for (const TurningWheel& wheel : wheels) {
    const test::EdgeVerdict verdict = judge_edges(edges, wheel, truth);
    const double worst = worst_reference(wheel, truth);
    std::printf(
        "line %zu: %lld teeth, %lld marks, %lld wrong, %.2f us from the scans beside them; references %.6f\n",
        wheel.line, static_cast<long long>(verdict.teeth), static_cast<long long>(verdict.marks),
        static_cast<long long>(verdict.wrong), verdict.worst_us, worst);
    EXPECT_EQ(verdict.wrong, 0);
    EXPECT_LT(verdict.worst_us, 1.0);
    // None is left out at the beginning or at the end either.
    EXPECT_LT(verdict.first, wheel.way_at(truth.front().true_s) + 1.0);
    EXPECT_GT(verdict.last, wheel.way_at(truth.back().true_s) - 1.0);
    EXPECT_GE(verdict.marks, (verdict.teeth - 1) / wheel.teeth);
    EXPECT_GT(verdict.marks, 60);
    // Half a code of the D/A is 1.7e-5 of the amplitude, a tick of the timer 1.3e-5 rad of the faster wheel.
    EXPECT_LT(worst, 5e-5);
  }
}

}  // namespace
}  // namespace roadbalance

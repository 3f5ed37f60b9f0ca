#include "firmware/backends/gpio/edge_maker.hpp"

#include <gtest/gtest.h>

#include "common/test/no_allocation.hpp"

namespace roadbalance {
namespace {

using Kind = InputEvent::Kind;

std::int64_t ns(const Edge& edge) {
  return to_ns(edge.time);
}

class EdgeMakerTest : public ::testing::Test {
 protected:
  /// Line 0 is a ring with a zero mark, line 1 a transducer in quadrature.
  enum Input : std::uint8_t { kRing, kMark, kA, kB };

  std::vector<Edge> take(Input input, Kind kind, std::int64_t monotonic_ns) {
    std::array<Edge, EdgeMaker::kMost> edges;
    const std::size_t count = maker.take(
        {.monotonic_ns = monotonic_ns, .machine_minus_monotonic_ns = 1'000, .input = input, .kind = kind},
        edges);
    return {edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(count)};
  }

  DeviceReport report{"gpio:test"};
  EdgeMaker maker{{{.offset = 4, .line = 0, .track = GpioTrack::kTooth, .key = ""},
                   {.offset = 5, .line = 0, .track = GpioTrack::kZeroMark, .key = ""},
                   {.offset = 6, .line = 1, .track = GpioTrack::kTooth, .key = ""},
                   {.offset = 7, .line = 1, .track = GpioTrack::kDirection, .key = ""}},
                  report};
};

TEST_F(EdgeMakerTest, StampsTeethAndMarksOfTheirLineByTheMachinesClock) {
  const auto tooth = take(kRing, Kind::kRising, 50'000);
  ASSERT_EQ(tooth.size(), 1U);
  EXPECT_EQ(tooth[0].kind, EdgeKind::kTooth);
  EXPECT_EQ(tooth[0].line, 0);
  EXPECT_EQ(ns(tooth[0]), 51'000);
  const auto mark = take(kMark, Kind::kRising, 60'000);
  ASSERT_EQ(mark.size(), 1U);
  EXPECT_EQ(mark[0].kind, EdgeKind::kZeroMark);
  EXPECT_EQ(mark[0].line, 0);
  EXPECT_FALSE(maker.has_direction(0));
  EXPECT_TRUE(maker.has_direction(1));
}

TEST_F(EdgeMakerTest, EveryEdgeIsLaterThanTheOneBefore) {
  EXPECT_EQ(ns(take(kRing, Kind::kRising, 50'000)[0]), 51'000);
  EXPECT_EQ(ns(take(kMark, Kind::kRising, 50'000)[0]), 51'001);
}

TEST_F(EdgeMakerTest, ALostEdgeIsDeclaredOnItsLineAndCounted) {
  const auto lost = take(kMark, Kind::kLost, 70'000);
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0].kind, EdgeKind::kLost);
  EXPECT_EQ(lost[0].line, 0);
  EXPECT_EQ(report.of(DeviceCounter::kEdgesLost), 1);
}

TEST_F(EdgeMakerTest, ATransducerInQuadratureTellsItsDirection) {
  maker.start(1, false, false);
  const auto forward = take(kA, Kind::kRising, 1);
  ASSERT_EQ(forward.size(), 1U);
  EXPECT_EQ(forward[0].kind, EdgeKind::kTooth);
  EXPECT_EQ(forward[0].line, 1);
  const auto backward = take(kA, Kind::kFalling, 2);
  ASSERT_EQ(backward.size(), 1U);
  EXPECT_EQ(backward[0].kind, EdgeKind::kToothBackward);
  EXPECT_TRUE(take(kB, Kind::kRising, 3).empty());

  const auto after_loss = take(kA, Kind::kFalling, 4);  // it is low already
  ASSERT_EQ(after_loss.size(), 1U);
  EXPECT_EQ(after_loss[0].kind, EdgeKind::kLost);
  EXPECT_EQ(report.of(DeviceCounter::kEdgesLost), 1);
}

TEST_F(EdgeMakerTest, AfterALossTheDirectionIsLearntAnew) {
  maker.start(1, false, false);
  take(kB, Kind::kLost, 1);
  EXPECT_TRUE(take(kA, Kind::kRising, 2).empty()) << "the level of the second track is not known";
  take(kB, Kind::kFalling, 3);
  EXPECT_EQ(take(kA, Kind::kFalling, 4)[0].kind, EdgeKind::kToothBackward);
}

TEST_F(EdgeMakerTest, NeverAllocates) {
  std::array<Edge, EdgeMaker::kMost> edges;
  const test::NoAllocation guard;
  for (std::int64_t t = 0; t < 1000; ++t)
    maker.take({.monotonic_ns = t, .input = static_cast<std::uint8_t>(t % 4), .kind = Kind::kRising}, edges);
}

}  // namespace
}  // namespace roadbalance

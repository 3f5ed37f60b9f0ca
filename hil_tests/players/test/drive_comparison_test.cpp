#include "hil_tests/players/drive_comparison.hpp"

#include <gtest/gtest.h>

namespace roadbalance::test {
namespace {

constexpr Timetable kTimetable{machine_time_from_ns(5'000'000'000), node_time_from_ns(1'000'000'000)};

/// A second of scans whose counts are their numbers, teeth every 2 ms, samples every 10 ms.
NodeDrive drive() {
  NodeDrive drive;
  for (std::int64_t k = 0; k < 1000; ++k) {
    Scan& scan = drive.scans.emplace_back();
    scan.index = k;
    scan.time = node_time_from_ns(1'000'000'000 + 1'000'000 * k);
    scan.counts.fill(static_cast<std::int32_t>(k + 1));
    if (k % 2 == 0) drive.edges.push_back({.time = scan.time, .line = static_cast<std::uint8_t>(k / 2 % 2)});
    if (k % 10 == 0)
      drive.signals.push_back({.time = scan.time, .signal = 3, .value = 0.1 * static_cast<double>(k)});
  }
  return drive;
}

/// The drive as it would be recorded: four seconds later, behind 17 silent scans, scans 30 us and edges 2 us
/// late.
NodeDrive recorded() {
  NodeDrive seen = drive();
  for (Scan& scan : seen.scans) scan.time += std::chrono::seconds(4) + std::chrono::microseconds(30);
  for (Edge& edge : seen.edges) edge.time += std::chrono::seconds(4) + std::chrono::microseconds(2);
  for (SignalSample& sample : seen.signals) sample.time += std::chrono::seconds(4);
  for (int k = 0; k < 17; ++k) {
    Scan silent;
    silent.time = seen.scans.front().time - std::chrono::milliseconds(1);
    seen.scans.insert(seen.scans.begin(), silent);
  }
  return seen;
}

DriveDifference difference(const NodeDrive& seen) {
  return compare(drive(), seen, kTimetable, 0.005);
}

TEST(DriveComparison, OfWhatIsAllThereTellsOnlyHowLateItIs) {
  const DriveDifference none = difference(recorded());
  EXPECT_EQ(none.scans, 0);
  EXPECT_EQ(none.edges, 0);
  EXPECT_EQ(none.samples, 0);
  EXPECT_EQ(none.scan.count(), 1000);
  EXPECT_EQ(none.edge.count(), 500);
  EXPECT_EQ(none.sample.count(), 100);
  EXPECT_NEAR(none.mean_angle_time_s(), -28e-6, 1e-12);
  EXPECT_NEAR(none.angle_time_spread_s(), 0.0, 1e-12);
}

TEST(DriveComparison, CountsEveryDifference) {
  NodeDrive seen = recorded();
  seen.scans[17 + 400].counts[11] += 1;
  EXPECT_EQ(difference(seen).scans, 1);
  seen.scans.pop_back();
  EXPECT_EQ(difference(seen).scans, 2);

  seen = recorded();
  seen.edges.pop_back();
  EXPECT_EQ(difference(seen).edges, 1);
  seen.edges.front().kind = EdgeKind::kLost;
  EXPECT_EQ(difference(seen).edges, 3) << "one missing of each line, and one of a kind that was not played";

  seen = recorded();
  seen.signals[50].value += 0.006;
  EXPECT_EQ(difference(seen).samples, 1);
  seen.signals.push_back({.time = seen.signals.back().time, .signal = 4, .value = 0.0});
  EXPECT_EQ(difference(seen).samples, 2);
}

TEST(DriveComparison, KnowsTheFarthestStamp) {
  NodeDrive seen = recorded();
  seen.edges[100].time += std::chrono::microseconds(500);
  EXPECT_NEAR(difference(seen).edge.mean_s(), 3e-6, 1e-12) << "500 us / 500 edges";
  EXPECT_NEAR(difference(seen).angle_time_spread_s(), 499e-6, 1e-9);
}

}  // namespace
}  // namespace roadbalance::test

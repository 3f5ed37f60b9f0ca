#include "host/analyser/sample_beat.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace roadbalance {
namespace {

constexpr double kRate_hz = 2000.0, kInterval_s = 0.1;

ScanBlock block(std::int64_t first_scan) {
  ScanBlock scans;
  scans.header = {.node = 1, .epoch = 5, .first_scan = first_scan, .scans = 20};
  scans.period_ps = 500'000'000;
  return scans;
}

WallTime wall(double seconds) {
  return WallTime(
      std::chrono::duration_cast<WallClock::duration>(std::chrono::duration<double>(1000.0 + seconds)));
}

/// Scans at which results are sent for `seconds` of samples that come `speed` times as fast as they
/// were taken, each up to `late_s` late.
std::vector<std::int64_t> beats(double seconds, double speed, double late_s, std::int64_t from = 0) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> late(0.0, late_s);
  SampleBeat beat(kInterval_s);
  std::vector<std::int64_t> scans;
  for (std::int64_t scan = from; static_cast<double>(scan) < seconds * kRate_hz; scan += 20)
    if (beat.due(block(scan), wall(static_cast<double>(scan) / kRate_hz / speed + late(random))))
      scans.push_back(scan + 20);
  return scans;
}

TEST(SampleBeat, TellsOfTheSameScansHoweverLateTheyCome) {
  const auto scans = beats(60.0, 1.0, 0.0);
  ASSERT_EQ(scans.size(), 600U);
  for (std::size_t k = 0; k < scans.size(); ++k) EXPECT_EQ(scans[k], 200 * static_cast<std::int64_t>(k + 1));
  EXPECT_EQ(beats(60.0, 1.0, 1.0), scans) << "a second of samples may wait and come at once";
  EXPECT_EQ(beats(60.0, 1.4, 0.1), scans);
  EXPECT_EQ(beats(60.0, 0.1, 0.3), scans);
  // One that joins in the middle has the same beats from then on.
  const auto later = beats(60.0, 1.0, 0.1, 5'060);
  EXPECT_EQ(later, std::vector(scans.begin() + 25, scans.end()));
}

TEST(SampleBeat, LeavesOutWhatWouldBeTooOften) {
  const auto scans = beats(3600.0, 20.0, 0.0);
  // 180 s by the wall clock, fifteen beats in each of them and the burst at the beginning.
  EXPECT_NEAR(static_cast<double>(scans.size()), 180.0 * 15.0 + 20.0, 20.0);
  for (const std::int64_t scan : scans) EXPECT_EQ(scan % 200, 0);
}

}  // namespace
}  // namespace roadbalance

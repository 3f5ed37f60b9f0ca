#include "host/analysis/spectra/levels_in_time.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "host/analyser/test/noise_drive.hpp"
#include "host/analysis/spectra/wheel_speeds.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kTenth_ns = 100'000'000;
constexpr std::int64_t kEpoch = 7;

Level level(int node, std::int64_t time_ns, double hz) {
  return {.node = test::car().node[static_cast<std::size_t>(node)].id,
          .time_ns = time_ns,
          .seconds = 0.1,
          .rotation_hz = {hz, hz}};
}

/// The car speeds up and slows down: 10 to 15 turns a second and back, all wheels alike.
double rate_hz(int tenth) {
  return 10.0 + 5.0 * (tenth < 300 ? tenth : 600 - tenth) / 300.0;
}

/// Levels of a drive of a minute, the second node's blocks `behind` tenths after the first's.
WheelSpeeds speeds_of(int behind, std::int64_t node_offset_ns) {
  WheelSpeeds speeds(test::car());
  LevelsInTime in_time([&](const Level& one) { speeds.take(one); });
  if (node_offset_ns != 0)
    for (int node : {0, 1})
      in_time.take(ClockFit{.node = level(node, 0, 0).node,
                            .epoch = kEpoch,
                            .state = ClockState::kLocked,
                            .host_ns = node * node_offset_ns,
                            .node_ns = 0});
  for (int tenth = 0; tenth < 600 + behind; ++tenth) {
    if (tenth >= behind)
      in_time.take(kEpoch, level(1, (tenth - behind) * kTenth_ns - node_offset_ns, rate_hz(tenth - behind)));
    if (tenth < 600) in_time.take(kEpoch, level(0, tenth * kTenth_ns, rate_hz(tenth)));
  }
  in_time.flush();
  return speeds;
}

TEST(LevelsInTime, SpeedsAndDriftDoNotDependOnWhenBlocksCame) {
  for (const std::int64_t offset_ns : {0L, 5'000'000'000'000L})
    for (const int behind : {0, 3, 200, 590}) {
      SCOPED_TRACE(behind);
      const WheelSpeeds speeds = speeds_of(behind, offset_ns);
      EXPECT_NEAR(speeds.drift_rad(0, 2), 0.0, 1e-9);
      EXPECT_EQ(speeds.classes(), speeds_of(0, 0).classes());
    }
}

TEST(LevelsInTime, HandsOnWhatIsOlderThanItsWindow) {
  std::vector<std::int64_t> seen;
  LevelsInTime in_time([&](const Level& one) { seen.push_back(one.time_ns); });
  const std::int64_t second = 10 * kTenth_ns;
  for (const std::int64_t at_s : {0, 100, 50, 121, 171}) in_time.take(kEpoch, level(0, at_s * second, 10.0));
  EXPECT_EQ(seen, (std::vector<std::int64_t>{0, 50 * second}));
  in_time.take(kEpoch, level(0, 1 * second, 10.0));
  EXPECT_EQ(seen.back(), 1 * second) << "too late to be put into order, and not lost";
  in_time.flush();
  EXPECT_EQ(seen.size(), 6U);
  EXPECT_TRUE(std::is_sorted(seen.begin() + 3, seen.end()));
}

}  // namespace
}  // namespace roadbalance

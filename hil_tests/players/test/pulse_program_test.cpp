#include "hil_tests/players/pulse_program.hpp"

#include <gtest/gtest.h>

#include <map>

namespace roadbalance::test {
namespace {

Edge edge(std::int64_t us, std::uint8_t line, EdgeKind kind) {
  return {.time = node_time_from_ns(1000 * us), .line = line, .kind = kind};
}

TEST(PulseProgram, RisesAtEveryEdgeAndFallsBeforeTheNext) {
  NodeDrive drive;
  drive.edges = {edge(1000, 0, EdgeKind::kTooth), edge(1010, 1, EdgeKind::kTooth),
                 edge(1050, 0, EdgeKind::kTooth), edge(1055, 0, EdgeKind::kZeroMark),
                 edge(5000, 0, EdgeKind::kTooth)};
  PulseProgram program;
  program.add(drive, 0, 4, 5);
  program.add(drive, 1, 6, std::nullopt);
  std::map<int, std::vector<std::pair<std::int64_t, bool>>> wire;
  NodeTime last{};
  for (const DriveLevel& level : program.take()) {
    EXPECT_GE(level.time, last);
    last = level.time;
    wire[level.wire].push_back({to_ns(level.time) / 1000, level.high});
  }
  using Levels = std::vector<std::pair<std::int64_t, bool>>;
  EXPECT_EQ(wire[4],
            (Levels{{1000, true}, {1025, false}, {1050, true}, {1150, false}, {5000, true}, {5100, false}}));
  EXPECT_EQ(wire[5], (Levels{{1055, true}, {1155, false}}));
  EXPECT_EQ(wire[6], (Levels{{1010, true}, {1110, false}}));
  EXPECT_EQ(wire.size(), 3U);
}

TEST(PulseProgram, LeavesOutMarksThatAreNotWiredAndTeethThatWereLost) {
  NodeDrive drive;
  drive.edges = {edge(1000, 0, EdgeKind::kTooth), edge(1500, 0, EdgeKind::kLost),
                 edge(1600, 0, EdgeKind::kZeroMark)};
  PulseProgram program;
  program.add(drive, 0, 0, std::nullopt);
  EXPECT_EQ(program.take().size(), 2U);
}

}  // namespace
}  // namespace roadbalance::test

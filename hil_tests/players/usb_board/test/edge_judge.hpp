#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "common/types/scan.hpp"
#include "hil_tests/players/usb_board/test/turning_wheels.hpp"

namespace roadbalance::test {

/// A scan's stamp, and when it truly was converted.
struct StampedScan {
  NodeTime stamp{};
  double true_s = 0.0;  ///< since the wheels' `begin`
};

struct EdgeVerdict {
  std::int64_t teeth = 0, marks = 0;
  std::int64_t wrong = 0;  ///< left out, reported twice, of the wrong kind or at the wrong place
  double worst_us = 0.0;   ///< of an edge against its wheel, on the line that the scans beside it are on
  double first = 0.0, last = 0.0;  ///< the wheel's way at the first and last reported tooth
};

/// Compares the reported edges of one wheel with its true way.
/// @param scans  of the whole time, in order
inline EdgeVerdict judge_edges(std::span<const Edge> edges, const TurningWheel& wheel,
                               std::span<const StampedScan> scans) {
  EdgeVerdict verdict;
  const EdgeKind tooth_kind = wheel.backward ? EdgeKind::kToothBackward : EdgeKind::kTooth;
  auto beside = scans.begin();
  std::int64_t last_tooth = -1;
  for (const Edge& edge : edges) {
    if (edge.line != wheel.line) continue;
    while (beside + 1 != scans.end() && beside->stamp < edge.time) ++beside;
    const double true_s = beside->true_s + to_seconds(edge.time - beside->stamp);
    const bool is_mark = edge.kind == EdgeKind::kZeroMark;
    const double way = wheel.way_at(true_s) - (is_mark ? wheel.mark() : 0.0);
    const std::int64_t tooth = std::llround(way);
    verdict.worst_us =
        std::max(verdict.worst_us, 1e6 * std::abs(wheel.seconds_of(way - static_cast<double>(tooth))));
    if (is_mark) {
      ++verdict.marks;
      if (tooth % wheel.teeth != 0 || (last_tooth >= 0 && tooth != last_tooth)) ++verdict.wrong;
      continue;
    }
    if (edge.kind != tooth_kind || (last_tooth >= 0 && tooth != last_tooth + 1)) ++verdict.wrong;
    if (verdict.teeth++ == 0) verdict.first = way;
    verdict.last = way;
    last_tooth = tooth;
  }
  return verdict;
}

}  // namespace roadbalance::test

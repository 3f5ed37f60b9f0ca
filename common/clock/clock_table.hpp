#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "common/clock/clock_map.hpp"

namespace roadbalance {

/// Each node's clock as known at an instant of a record: the fit that came last and, while that is in
/// kAcquire, those before it that hold until a better one comes.
///
/// Beyond kMostClocks epochs the one whose last fit is the oldest is forgotten.
class ClockTable {
 public:
  static constexpr std::size_t kMostClocks = 128;

  /// False if the table has it already, and changes nothing then: segments of a record begin with what was
  /// known there already, and the record continued in another folder repeats some of it.
  bool take(const ClockFit& fit);

  struct Row {
    ClockMap known;      ///< of those that are; nothing at first and after a break of the time base
    ClockFit last = {};  ///< may be the last one known
  };
  /// By (node, epoch).
  const std::map<std::pair<std::int32_t, std::int64_t>, Row>& rows() const { return rows_; }

 private:
  void make_room();

  std::map<std::pair<std::int32_t, std::int64_t>, Row> rows_;
};

}  // namespace roadbalance

#pragma once

#include <cstdint>

#include "common/clock/clocks.hpp"

namespace roadbalance {

/// Numbers a node's scans through all runs of its board: within a run as the board does; over the absence
/// between two by the time that passed.
class ScanNumbering {
 public:
  struct Number {
    std::int64_t index = 0;
    bool after_absence = false;
  };

  /// The board was there (again) and started; its scans count from 0.
  void start_run() noexcept { first_of_run_ = true; }

  /// @param period_s  between the run's scans by the machine's clock; of an absence that of the run before
  /// counts
  Number number(std::int64_t index_in_run, NodeTime time, double period_s) noexcept;

 private:
  bool first_of_run_ = true;
  bool any_ = false;
  std::int64_t offset_ = 0;  ///< what is added to the board's index
  std::int64_t last_index_ = 0;
  NodeTime last_time_{};
  double period_s_ = 0.0;
};

}  // namespace roadbalance

#include "firmware/backends/usb/scan_numbering.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {

ScanNumbering::Number ScanNumbering::number(std::int64_t index_in_run, NodeTime time,
                                            double period_s) noexcept {
  Number number;
  if (first_of_run_ && any_) {
    const auto passed = std::llround(to_seconds(time - last_time_) / period_s_);
    offset_ = last_index_ + std::max<std::int64_t>(passed, 1) - index_in_run;
    number.after_absence = true;
  }
  first_of_run_ = false;
  any_ = true;
  number.index = index_in_run + offset_;
  last_index_ = number.index;
  last_time_ = time;
  period_s_ = period_s;
  return number;
}

}  // namespace roadbalance

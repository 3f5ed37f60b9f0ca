#include "host/analysis/spectra/levels_in_time.hpp"

namespace roadbalance {

void LevelsInTime::take(const ClockFit& fit) {
  clocks_.take(fit);
}

void LevelsInTime::take(std::int64_t epoch, const Level& level) {
  waiting_.emplace(std::pair(time_ns(epoch, level), -level.node), level);
  while (waiting_.rbegin()->first.first - waiting_.begin()->first.first > kWindow_ns) {
    consume_(waiting_.begin()->second);
    waiting_.erase(waiting_.begin());
  }
}

void LevelsInTime::flush() {
  for (const auto& waiting : waiting_) consume_(waiting.second);
  waiting_.clear();
}

std::int64_t LevelsInTime::time_ns(std::int64_t epoch, const Level& level) const {
  if (clocks_.rows().empty()) return level.time_ns;
  const auto row = clocks_.rows().find({level.node, epoch});
  if (row != clocks_.rows().end() && row->second.known.is_known())
    return row->second.known.host_time_ns(level.time_ns);
  return waiting_.empty() ? level.time_ns : waiting_.rbegin()->first.first;
}

}  // namespace roadbalance

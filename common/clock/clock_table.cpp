#include "common/clock/clock_table.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

// By both clocks: the host's begins anew with the host, the node's may be set back by a break.
bool is_no_later(const ClockFit& fit, const ClockFit& than) {
  return fit.host_ns <= than.host_ns && fit.node_ns <= than.node_ns;
}

}  // namespace

void ClockTable::make_room() {
  if (rows_.size() < kMostClocks) return;
  rows_.erase(std::min_element(rows_.begin(), rows_.end(), [](const auto& a, const auto& b) {
    return a.second.last.host_ns < b.second.last.host_ns;
  }));
}

bool ClockTable::take(const ClockFit& fit) {
  const std::pair key{fit.node, fit.epoch};
  auto row = rows_.find(key);
  if (row == rows_.end()) {
    make_room();
    row = rows_.emplace(key, Row()).first;
  } else {
    const auto& [known, last] = row->second;
    if (is_no_later(fit, fit.is_known() && known.is_known() ? *known.last() : last)) return false;
  }
  auto& [known, last] = row->second;
  if (fit.is_known())
    known.take(fit);
  else if (fit.breaks > last.breaks)
    known.reset();
  last = fit;
  return true;
}

}  // namespace roadbalance

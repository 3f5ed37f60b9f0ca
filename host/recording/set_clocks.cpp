#include "host/recording/set_clocks.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "common/types/bounded_time.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kBoot = std::numeric_limits<std::int64_t>::min();

bool is_credible(std::int64_t change_us) {
  return -kUtcLimit_us <= change_us && change_us <= kUtcLimit_us;
}

}  // namespace

void SetClocks::take(const Note& note) {
  if (note.time_us == 0 || changes_us_.size() >= kMost) return;
  // As RecordedClocks::take().
  const bool is_new_boot = note.incarnation > incarnation_ && note.host_ns < host_ns_;
  if (is_new_boot) changes_us_.push_back(kBoot);
  incarnation_ = note.incarnation;
  host_ns_ = note.host_ns;
  if (note.kind == NoteKind::kClockSet && is_credible(note.a)) changes_us_.push_back(note.a);
}

std::int64_t SetClocks::utc_us(const Stamp& stamp) const {
  std::int64_t utc_us = stamp.utc_us;
  if (utc_us == 0) return 0;
  for (std::size_t k = stamp.notes; k < changes_us_.size() && changes_us_[k] != kBoot; ++k)
    utc_us = std::clamp(utc_us + changes_us_[k], -kUtcLimit_us, kUtcLimit_us);
  return utc_us;
}

}  // namespace roadbalance

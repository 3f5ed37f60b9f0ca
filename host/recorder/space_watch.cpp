#include "host/recorder/space_watch.hpp"

#include <algorithm>
#include <array>

namespace roadbalance {
namespace {

using std::chrono::seconds;
constexpr std::array kWarnings_s{3600.0, 900.0, 300.0};
constexpr double kRearm = 1.25;  // a warning comes again when there was so much more time meanwhile
constexpr seconds kRateSpan{60};
constexpr seconds kShortestSpan{5};  // a rate over less is none
constexpr seconds kRefusal{1};

}  // namespace

std::int64_t SpaceWatch::usable_bytes() const {
  return std::max<std::int64_t>(0, usable_bytes_);
}

SpaceWatch::Event SpaceWatch::take(std::int64_t free_bytes, std::int64_t recorded_bytes, WallTime now) {
  if (free_bytes < 0) return Event::kNone;
  usable_bytes_ = free_bytes - reserve_bytes_;
  if (samples_.empty() || now - samples_.back().at >= seconds(1)) samples_.push_back({now, recorded_bytes});
  while (now - samples_.front().at > kRateSpan) samples_.pop_front();
  const double span_s = std::chrono::duration<double>(now - samples_.front().at).count();
  const auto recorded = static_cast<double>(recorded_bytes - samples_.front().bytes);
  seconds_left_ = now - samples_.front().at >= kShortestSpan && recorded > 0
                      ? static_cast<double>(usable_bytes()) * span_s / recorded
                      : -1;

  const bool refuses = refuses_ || (refused_at_ && now - *refused_at_ < kRefusal);
  // Half a reserve more than nothing, so that the state does not flicker.
  if (full_ && !refuses && usable_bytes_ >= reserve_bytes_ / 2) {
    full_ = false;
    refused_at_.reset();
    return Event::kFree;
  }
  if (!full_ && usable_bytes_ <= 0) {
    full_ = true;
    return Event::kFull;
  }
  return !full_ && crosses_a_warning() ? Event::kWarning : Event::kNone;
}

bool SpaceWatch::crosses_a_warning() {
  if (seconds_left_ < 0) return false;
  const auto below = [this](double factor) {
    return static_cast<int>(std::count_if(kWarnings_s.begin(), kWarnings_s.end(),
                                          [&](double limit_s) { return seconds_left_ < limit_s * factor; }));
  };
  warnings_ = std::min(warnings_, below(kRearm));
  if (below(1.0) <= warnings_) return false;
  warnings_ = below(1.0);
  return true;
}

SpaceWatch::Event SpaceWatch::refuse(WallTime now) {
  refused_at_ = now;
  refuses_ = true;
  if (full_) return Event::kNone;
  full_ = true;
  return Event::kFull;
}

}  // namespace roadbalance

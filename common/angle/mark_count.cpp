#include "common/angle/mark_count.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {
namespace {

constexpr double kSamePlace_pitches = 0.75;
constexpr std::size_t kEnough = 6;  // marks, to name their counts

}  // namespace

double MarkCount::apart(std::size_t a, std::size_t b) const noexcept {
  return std::abs(std::remainder(position_[a] - position_[b], static_cast<double>(teeth_)));
}

void MarkCount::add(double position) noexcept {
  if (size_ == kWindow) {
    std::copy(position_.begin() + 1, position_.end(), position_.begin());
    --size_;
  }
  position_[size_++] = position;
  if (judged())
    bad_ = 0;
  else
    ++bad_;
  // A fault that comes now and then never lasts for kWindow marks.
  trusted_ = trusted_ ? bad_ < kWindow : bad_ == 0;
}

bool MarkCount::judged() const noexcept {
  struct Place {
    std::size_t marks = 0, first = 0, last = 0;
  };
  Place best;
  for (std::size_t k = 0; k < size_; ++k) {
    Place place;
    for (std::size_t i = 0; i < size_; ++i) {
      if (apart(i, k) > kSamePlace_pitches) continue;
      if (place.marks++ == 0) place.first = i;
      place.last = i;
    }
    if (place.marks > best.marks) best = place;
  }
  // A count that slips from time to time, or jitter, spreads the places of a good mark, too.
  const std::size_t least = size_ < kWindow ? size_ / 2 + 1 : size_ / 3;
  if (best.marks < std::max<std::size_t>(2, least)) return false;
  const std::size_t within = best.last - best.first + 1;
  // Two marks a turn leave nearly a half between; trust that was won is not lost for a few false ones.
  const double most = trusted_ ? 0.4 : 1.0 / 3.0;
  return static_cast<double>(within - best.marks) < most * static_cast<double>(within);
}

std::array<int, 2> MarkCount::counts() const noexcept {
  std::array<int, 2> most{};
  if (trusted_ || size_ < kEnough) return most;
  std::array<int, 2> times{};
  for (std::size_t k = 1; k < size_; ++k) {
    const int count = static_cast<int>(std::lround(position_[k] - position_[k - 1]));
    if (count <= 0 || count == most[0] || count == most[1]) continue;
    int alike = 0;
    for (std::size_t i = 1; i < size_; ++i)
      if (std::lround(position_[i] - position_[i - 1]) == count) ++alike;
    if (alike > times[0]) {
      most = {count, most[0]};
      times = {alike, times[0]};
    } else if (alike > times[1]) {
      most[1] = count;
      times[1] = alike;
    }
  }
  return most;
}

}  // namespace roadbalance

#include "host/analysis/identify/grid_stream.hpp"

#include <algorithm>
#include <cmath>

#include "common/clock/clock_model.hpp"

namespace roadbalance {
namespace {

/// Samples may lie this far, in periods, from the grid and be taken for its own: 0.02 periods at 2 kHz are
/// 0.06 degrees at 18 Hz.
constexpr double kGridTolerance = 0.02;
/// Two nominal rates may differ by so much; no converter is further off.
constexpr double kRateTolerance = 1e-3;
constexpr double kSpacingTolerance = 1e-2;  // of stamps that jump
// A second apart: the recorder needs two exchanges to see a break.
constexpr int kDistrusted = 3;
constexpr double kFarthest = 1e15;  // periods; still exact as a double
constexpr double kWorthSaying_s = 5.0;
constexpr std::size_t kMostClocks = 8;

}  // namespace

GridStream::Last GridStream::last_of(const ScanBlock& block) {
  return {block.header.epoch, block.header.first_scan + block.header.scans, block.header.scans,
          block.header.time_ns};
}

GridStream::Clock* GridStream::clock_of(std::int64_t epoch) {
  const auto found =
      std::find_if(clocks_.begin(), clocks_.end(), [&](const Clock& c) { return c.epoch == epoch; });
  return found == clocks_.end() ? nullptr : &*found;
}

GridStream::Clock& GridStream::declare(std::int64_t epoch) {
  if (Clock* known = clock_of(epoch)) return *known;
  if (clocks_.size() == kMostClocks) {
    // One that never answered has placed nothing.
    const auto idle = std::ranges::find_if(clocks_, [](const Clock& c) { return !c.map.is_known(); });
    clocks_.erase(idle == clocks_.end() ? clocks_.begin() : idle);
  }
  if (epoch == placed_.epoch && placed_.next_scan >= 0) {  // earlier samples stood in the wrong place
    rows.clear();
    row = 0;
    placed_ = {};
  }
  return clocks_.emplace_back(Clock{epoch, {}});
}

void GridStream::take(const ClockFit& fit, Grid& grid) {
  if (alone_ || !heard_.take(fit)) return;
  Clock& clock = declare(fit.epoch);
  if (!fit.is_known()) {
    if (fit.breaks > clock.breaks) {
      clock.map.reset();
      clock.distrusted = 0;
    }
    clock.breaks = fit.breaks;
    return;  // a recorder that has just begun has no fit yet; the last one's still holds
  }
  const bool says_so = fit.breaks != clock.breaks;
  clock.breaks = fit.breaks;
  if (!says_so && clock.distrusted > 0 && --clock.distrusted > 0) return;
  clock.distrusted = 0;
  clock.map.take(fit);
  std::deque<ScanBlock> blocks;
  blocks.swap(waiting_);
  for (const ScanBlock& block : blocks) {
    const Clock* known = clock_of(block.header.epoch);
    if (known && !known->map.is_known())
      waiting_.push_back(block);
    else
      place(block, known ? &known->map : nullptr, grid);
  }
}

void GridStream::take(const ScanBlock& block, Grid& grid) {
  aligner_.add(block, [&](const ScanBlock& aligned) { take_aligned(aligned, grid); });
}

void GridStream::take_aligned(const ScanBlock& block, Grid& grid) {
  if (grid.period_ps == 0) grid.period_ps = block.period_ps;
  const double rates = static_cast<double>(block.period_ps) / static_cast<double>(grid.period_ps);
  if (std::abs(rates - 1.0) > kRateTolerance) {
    other_period_ps_ = block.period_ps;
    return;
  }
  Clock* const clock = alone_ ? nullptr : clock_of(block.header.epoch);
  if (clock && jumps(block, *clock)) {
    clock->map.reset();
    clock->distrusted = kDistrusted;
  }
  came_ = last_of(block);
  came_host_ns_.reset();
  const bool is_told = clock && clock->map.is_known();
  if (is_told) came_host_ns_ = clock->map.host_time_ns(block.header.time_ns);
  if (clock && !is_told) {
    waiting_.push_back(block);
    while (awaited_s() > kLongestWait_s) waiting_.pop_front();
    return;
  }
  place(block, clock ? &clock->map : nullptr, grid);
}

/// Scans are even; if they go on and their instants do not, the clock was set and the fit is from before.
bool GridStream::jumps(const ScanBlock& block, const Clock& clock) const {
  if (!came_.goes_on_with(block.header)) return false;
  const bool mapped = clock.map.is_known() && came_host_ns_;
  const std::int64_t passed_ns = mapped ? clock.map.host_time_ns(block.header.time_ns) - *came_host_ns_
                                        : block.header.time_ns - came_.time_ns;
  const double expected_ns = static_cast<double>(came_.scans) * static_cast<double>(block.period_ps) * 1e-3;
  return std::abs(static_cast<double>(passed_ns) - expected_ns) >
         static_cast<double>(ClockModel::kLeastBreak_ns);
}

double GridStream::awaited_s() const {
  if (waiting_.empty()) return 0.0;
  return 1e-9 *
         std::abs(static_cast<double>(waiting_.back().header.time_ns - waiting_.front().header.time_ns));
}

void GridStream::place(const ScanBlock& block, const ClockMap* map, Grid& grid) {
  const std::int64_t node_ns = block.header.time_ns;
  const std::int64_t time_ns = map ? map->host_time_ns(node_ns) : node_ns;
  if (!grid.origin_ns) grid.origin_ns = time_ns;
  const double position = grid.position(time_ns);
  if (!(std::abs(position) < kFarthest)) return;

  const bool same_epoch = block.header.epoch == placed_.epoch;
  const bool follows = placed_.goes_on_with(block.header);
  if (!same_epoch) {
    resampling_ = false;
    spacing_ = 0.0;
  }
  if (!resampling_ && (map || std::abs(position - std::round(position)) > kGridTolerance)) {
    resampling_ = true;
    if (!resampler_) resampler_ = std::make_unique<Resampler>();
    resampler_->reset();
  }
  if (resampling_) {
    resampled_.clear();
    measure_spacing(block, map, follows, grid);
    resampler_->add(block, position, spacing_, follows, grid, resampled_);
    for (const GridRows& more : resampled_) queue(more);
  } else {
    copy(block, position, same_epoch);
  }
  placed_ = last_of(block);
}

/// From the node's stamps, which show the converter's true rate and do not move when a fit does.
void GridStream::measure_spacing(const ScanBlock& block, const ClockMap* map, bool follows,
                                 const Grid& grid) {
  const double nominal = static_cast<double>(block.period_ps) / static_cast<double>(grid.period_ps);
  if (spacing_ == 0.0) spacing_ = nominal;
  if (!follows || placed_.scans == 0) return;
  const double node_ns =
      static_cast<double>(block.header.time_ns - placed_.time_ns) / static_cast<double>(placed_.scans);
  const double measured = node_ns * 1000.0 / static_cast<double>(grid.period_ps) /
                          (1.0 + (map ? map->line_at(block.header.time_ns).drift : 0.0));
  if (std::abs(measured / nominal - 1.0) < kSpacingTolerance) spacing_ = measured;
}

void GridStream::copy(const ScanBlock& block, double position, bool same_epoch) {
  GridRows own;
  own.first_index = std::llround(position);
  own.rows = block.header.scans;
  own.time_ns = block.header.time_ns;
  own.restart = !same_epoch;
  own.overload = block.overload;
  own.quality = block.quality;
  for (std::size_t r = 0; r < static_cast<std::size_t>(own.rows); ++r)
    std::transform(block.counts[r].begin(), block.counts[r].end(), own.counts[r].begin(),
                   [](std::int32_t count) { return static_cast<float>(count); });
  queue(own);
}

/// Time that runs backwards (a break, another epoch) makes worthless what lies ahead.
void GridStream::queue(const GridRows& more) {
  while (!rows.empty() && rows.back().first_index + rows.back().rows > more.first_index) {
    rows.pop_back();
    if (rows.empty()) row = 0;
  }
  rows.push_back(more);
}

std::string GridStream::refusal() const {
  if (other_period_ps_ != 0)
    return "node " + std::to_string(node_) + ": its samples have another rate than the others': one each " +
           std::to_string(static_cast<double>(other_period_ps_) * 1e-6) + " us";
  if (awaited_s() > kWorthSaying_s)
    return "node " + std::to_string(node_) +
           ": its clock is not known, because it does not answer the recorder's questions or its time broke";
  return {};
}

}  // namespace roadbalance

#include "host/recording/levels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/bus/channel_faults.hpp"

namespace roadbalance {
namespace {

constexpr double kAngle_s = 0.002;

}  // namespace

LevelMeter::LevelMeter(const VehicleConfig& vehicle, const NodeConfig& node) : node_(node) {
  for (int line = kEncoderLines - 1; line >= 0; --line)
    if (const WheelConfig* const wheel = vehicle.wheel_at(node, line)) {
      has_wheel_[static_cast<std::size_t>(line)] = true;
      line_ = line;
      rolling_radius_m_ = wheel->rolling_radius_m;
    }
}

void LevelMeter::add(const ScanBlock& block) {
  overload_ |= static_cast<std::uint32_t>(block.overload);
  period_s_ = static_cast<double>(block.period_ps) * 1e-12;
  end_ns_ = block.row_time_ns(block.header.scans);
  if (block.header.first_scan != next_scan_)
    for (Turning& turning : turning_) turning.before.reset();  // the angle across a hole is not a speed
  next_scan_ = block.header.first_scan + block.header.scans;
  for (std::int64_t r = 0; r < block.header.scans; ++r) {
    const auto& row = block.counts[static_cast<std::size_t>(r)];
    for (std::size_t c = 0; c < row.size(); ++c) {
      Sums& sums = sums_[c];
      const double value = row[c];
      if (scans_ == 0) sums = {value, 0.0, 0.0, value, value, sums.last, sums.unchanged};
      sums.unchanged = row[c] == sums.last ? sums.unchanged + 1 : 0;
      sums.last = row[c];
      sums.sum += value - sums.first;
      sums.squares += (value - sums.first) * (value - sums.first);
      sums.least = std::min(sums.least, value);
      sums.most = std::max(sums.most, value);
    }
    ++scans_;
    for (int line = 0; line < kEncoderLines; ++line) add_turn(line, block, row);
  }
}

/// Adds the angle from the reference of some scans before to this one's: half a turn takes longer than
/// kAngle_s at any speed.
void LevelMeter::add_turn(int line, const ScanBlock& block, const std::array<std::int32_t, kChannels>& row) {
  Turning& turning = turning_[static_cast<std::size_t>(line)];
  if (!has_wheel_[static_cast<std::size_t>(line)] || (block.quality & quality_no_reference(line)) != 0) {
    turning.before.reset();
    return;
  }
  if (turning.before && static_cast<double>(++turning.since) * period_s_ < kAngle_s) return;
  const auto sine = static_cast<std::size_t>(kAccelerations + 2 * line);
  const std::array<double, 2> now{static_cast<double>(row[sine]), static_cast<double>(row[sine + 1])};
  if (turning.before) {
    const auto [s, c] = *turning.before;
    turning.turned_rad += std::atan2(now[0] * c - now[1] * s, now[1] * c + now[0] * s);
    turning.scans += turning.since;
  }
  turning.before = now;
  turning.since = 0;
}

double LevelMeter::Turning::rotation_hz(double period_s) const {
  if (scans == 0) return std::numeric_limits<double>::quiet_NaN();
  return turned_rad / (2.0 * std::numbers::pi * static_cast<double>(scans) * period_s);
}

std::optional<Level> LevelMeter::take() {
  if (scans_ == 0) return std::nullopt;
  Level level;
  level.node = node_.id;
  level.time_ns = end_ns_;
  level.seconds = static_cast<double>(scans_) * period_s_;
  level.overload = overload_;
  const auto count = static_cast<double>(scans_);
  for (std::size_t c = 0; c < sums_.size(); ++c) {
    const bool acceleration = c < kAccelerations;
    if (acceleration && c >= node_.channel.size()) continue;
    const Sums& sums = sums_[c];
    const double mean = sums.first + sums.sum / count;
    const double scale = acceleration ? node_.channel[c].scale_m_s2_per_count : 1.0 / kFullScaleCounts;
    level.mean[c] = acceleration ? node_.channel[c].to_si(mean) : mean * scale;
    const double variance = sums.squares / count - (sums.sum / count) * (sums.sum / count);
    level.rms[c] = std::sqrt(std::max(variance, 0.0)) * std::abs(scale);
    level.peak[c] = std::max(sums.most - mean, mean - sums.least) * std::abs(scale);
    if (!acceleration) continue;
    if (sums.unchanged >= kDeadScans) set_dead(level, c);
    if (std::max(sums.most, -sums.least) > kOverloadShare * kFullScaleCounts) level.overload |= 1U << c;
  }
  for (std::size_t line = 0; line < turning_.size(); ++line) {
    level.rotation_hz[line] = turning_[line].rotation_hz(period_s_);
    turning_[line] = {.before = turning_[line].before, .since = turning_[line].since};
  }
  level.speed_m_s =
      line_ ? level.rotation_hz[static_cast<std::size_t>(*line_)] * 2.0 * std::numbers::pi * rolling_radius_m_
            : std::numeric_limits<double>::quiet_NaN();
  scans_ = 0;
  overload_ = 0;
  return level;
}

}  // namespace roadbalance

#include "tools/import/tachometer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {
namespace {

constexpr double kLow = 0.25;     // of the way between the levels
constexpr double kMissing = 1.5;  // periods
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TachometerColumn TachometerColumn::parse(const std::string& text) {
  const std::size_t at = text.rfind('=');
  if (at == std::string::npos || at == 0)
    throw ConfigError("--tachometer: \"" + text + "\" names no wheel; allowed: COLUMN=WHEEL");
  const std::string name = text.substr(at + 1);
  const auto wheel = std::ranges::find(kWheelNames, name);
  if (wheel == kWheelNames.end())
    throw ConfigError("--tachometer: " + text + ": \"" + name +
                      "\" is no wheel; allowed: front_left, front_right, rear_left, rear_right");
  return {text.substr(0, at), static_cast<int>(wheel - kWheelNames.begin())};
}

void TachometerLevels::add(double value) {
  if (std::isnan(value)) return;
  least = samples == 0 ? value : std::min(least, value);
  largest = samples == 0 ? value : std::max(largest, value);
  ++samples;
}

TachometerPulses::TachometerPulses(const TachometerLevels& levels)
    : low_(levels.least + kLow * (levels.largest - levels.least)),
      middle_(levels.least + 0.5 * (levels.largest - levels.least)),
      way_(levels.largest - levels.least),
      before_(kNone) {}

std::optional<double> TachometerPulses::add(double time_s, double period_s, double value) {
  if (std::isnan(before_) || std::isnan(value) || time_s - before_s_ > kMissing * period_s) was_low_ = false;
  std::optional<double> pulse;
  if (was_low_ && value >= middle_) {
    // The sample before is below: else it would have been the pulse.
    const double rise = value - before_;
    pulse = before_s_ + (middle_ - before_) / rise * (time_s - before_s_);
    const double sigma_s = std::min(1.0, rise / way_) * (time_s - before_s_) / std::sqrt(12.0);
    squares_ += sigma_s * sigma_s;
    ++pulses_;
    was_low_ = false;
  }
  if (value < low_) was_low_ = true;
  before_ = value;
  before_s_ = time_s;
  return pulse;
}

double TachometerPulses::sigma_s() const {
  return pulses_ == 0 ? 0.0 : std::sqrt(squares_ / static_cast<double>(pulses_));
}

}  // namespace roadbalance

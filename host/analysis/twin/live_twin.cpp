#include "host/analysis/twin/live_twin.hpp"

#include <stdexcept>
#include <utility>

namespace roadbalance {

LiveTwin::LiveTwin(const VehicleConfig& vehicle, OnSecond on_second)
    : vehicle_(vehicle),
      channels_(TwinChannels::of(vehicle)),
      twin_(channels_, TwinCar::nominal(vehicle), SensorSamples::rate_hz(vehicle)),
      shares_(channels_, SensorSamples::rate_hz(vehicle), kMemory_s),
      on_second_(std::move(on_second)),
      samples_(vehicle, channels_, [this](const SensorSample& sample) { take_sample(sample); }) {
  for (int w = 0; w < kWheels; ++w) balance_[static_cast<std::size_t>(w)].wheel = w;
}

void LiveTwin::take(const Identification& identification) {
  identification_ = identification;
  known_better_ = true;
}

void LiveTwin::take(const Balance& balance) {
  if (balance.wheel < 0 || balance.wheel >= kWheels) return;
  balance_[static_cast<std::size_t>(balance.wheel)] = balance;
  known_better_ = true;
}

void LiveTwin::take_sample(const SensorSample& sample) {
  const TwinSample* const predicted = twin_.consume(sample);
  const TwinSecond* const second = predicted ? shares_.add(*predicted) : nullptr;
  if (!second) return;
  on_second_(*second);
  // Between two seconds: an estimate comes in five messages, a car is one.
  if (!std::exchange(known_better_, false)) return;
  try {
    twin_.change(TwinCar::estimated(vehicle_, identification_, balance_));
  } catch (const std::invalid_argument&) {
    // No car moves like that: the one that was is the best there is.
  }
}

}  // namespace roadbalance

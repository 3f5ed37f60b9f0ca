#include "common/dbc/dbc_reading.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace roadbalance {
namespace {

bool in_range(const DbcSignal& signal, double value) {
  const CanNumber number = signal.place.number;
  const bool counts = number == CanNumber::kUnsigned || number == CanNumber::kSigned;
  const double rounding =
      counts ? 0.5 * std::abs(signal.place.scale)
             : std::numeric_limits<float>::epsilon() * std::max(std::abs(signal.low), std::abs(signal.high));
  return value >= signal.low - rounding && value <= signal.high + rounding;
}

}  // namespace

DbcReading read_signal(const DbcMessage& message, const DbcSignal& signal, const CanFrame& frame) noexcept {
  using Status = DbcReading::Status;
  if (frame.size < message.size) return {.status = Status::kTooShort};
  if (signal.when_bits) {
    const DbcSignal* const multiplexor = message.multiplexor();
    if (!multiplexor || multiplexor->place.bits(frame) != signal.when_bits)
      return {.status = Status::kAbsent};
  }
  const auto bits = signal.place.bits(frame);
  if (!bits) return {.status = Status::kTooShort};
  const double raw = signal.place.raw(*bits);
  const double value = signal.place.value(raw);
  const bool named = std::ranges::find(signal.codes, raw, &DbcCode::raw) != signal.codes.end();
  const bool inside = signal.has_range() ? in_range(signal, value) : !(named && !signal.unit.empty());
  if (!inside) return {.status = named ? Status::kNotAvailable : Status::kOutOfRange};
  if (!std::isfinite(value)) return {.status = Status::kOutOfRange};
  return {.status = Status::kOk, .value = value};
}

}  // namespace roadbalance

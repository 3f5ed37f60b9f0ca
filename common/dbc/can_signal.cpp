#include "common/dbc/can_signal.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace roadbalance {
namespace {

/// The bit after `bit` on the way through the signal.
int next_bit(ByteOrder order, int bit) {
  if (order == ByteOrder::kLittleEndian) return bit + 1;
  return bit % 8 == 0 ? bit + 15 : bit - 1;
}

/// Which bit of the number the n-th on the way is.
int weight(const CanSignal& signal, int n) {
  return signal.order == ByteOrder::kLittleEndian ? n : signal.length - 1 - n;
}

}  // namespace

bool CanSignal::fits(std::size_t frame_bytes) const noexcept {
  if (length < 1 || length > 64 || start_bit < 0) return false;
  int bit = start_bit;
  // The way never leads back to an earlier byte, so that the last bit decides.
  for (int n = 1; n < length; ++n) bit = next_bit(order, bit);
  return static_cast<std::size_t>(bit / 8) < frame_bytes;
}

std::optional<std::uint64_t> CanSignal::bits(const CanFrame& frame) const noexcept {
  if (!fits(frame.size)) return std::nullopt;
  std::uint64_t bits = 0;
  int bit = start_bit;
  for (int n = 0; n < length; ++n, bit = next_bit(order, bit)) {
    const std::uint64_t one = frame.data[static_cast<std::size_t>(bit / 8)] >> (bit % 8) & 1U;
    bits |= one << weight(*this, n);
  }
  return bits;
}

double CanSignal::raw(std::uint64_t bits) const noexcept {
  switch (number) {
    case CanNumber::kUnsigned:
      return static_cast<double>(bits);
    case CanNumber::kSigned:
      // The sign bit stands for -2^(length-1): shift it to the top and back.
      return static_cast<double>(static_cast<std::int64_t>(bits << (64 - length)) >> (64 - length));
    case CanNumber::kFloat:
      return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    case CanNumber::kDouble:
      return std::bit_cast<double>(bits);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

bool CanSignal::put_bits(std::uint64_t bits, CanFrame& frame) const noexcept {
  if (!fits(frame.size)) return false;
  int bit = start_bit;
  for (int n = 0; n < length; ++n, bit = next_bit(order, bit)) {
    auto& byte = frame.data[static_cast<std::size_t>(bit / 8)];
    const auto mask = static_cast<std::uint8_t>(1U << (bit % 8));
    const bool one = (bits >> weight(*this, n) & 1U) != 0;
    byte = static_cast<std::uint8_t>(one ? byte | mask : byte & ~mask);
  }
  return true;
}

bool CanSignal::put(double value, CanFrame& frame) const noexcept {
  const double number_raw = (value - offset) / scale;
  if (number == CanNumber::kDouble) return put_bits(std::bit_cast<std::uint64_t>(number_raw), frame);
  if (number == CanNumber::kFloat) {
    if (std::abs(number_raw) > std::numeric_limits<float>::max()) return false;
    return put_bits(std::bit_cast<std::uint32_t>(static_cast<float>(number_raw)), frame);
  }
  const double count = std::nearbyint(number_raw);
  const bool is_signed = number == CanNumber::kSigned;
  const double low = is_signed ? -std::ldexp(1.0, length - 1) : 0.0;
  const double end = std::ldexp(1.0, is_signed ? length - 1 : length);
  if (!(count >= low && count < end)) return false;
  return put_bits(is_signed ? static_cast<std::uint64_t>(static_cast<std::int64_t>(count))
                            : static_cast<std::uint64_t>(count),
                  frame);
}

}  // namespace roadbalance

#include "common/clock/datagram.hpp"

#include <algorithm>

#include "common/types/block.hpp"
#include "common/types/crc32c.hpp"

namespace roadbalance {
namespace {

constexpr std::array<std::uint8_t, 5> kBegin{'R', 'B', 'C', 'K', 1};
constexpr std::size_t kKind = 5, kStamps = 6, kZero = 7, kNode = 8, kEpoch = 12, kNumber = 20, kReceived = 28,
                      kAnswered = 36, kCrc = 44;

template <typename Number>
void store(Number value, std::uint8_t* bytes) {
  const auto bits = static_cast<std::uint64_t>(value);
  for (std::size_t k = 0; k < sizeof value; ++k)
    bytes[k] = static_cast<std::uint8_t>(bits >> (8 * (sizeof value - 1 - k)));
}

template <typename Number>
Number load(const std::uint8_t* bytes) {
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < sizeof(Number); ++k) bits = bits << 8 | bytes[k];
  return static_cast<Number>(bits);
}

bool is_clock(std::int64_t ns) {
  return -kClockLimit_ns <= ns && ns <= kClockLimit_ns;
}

bool in_bounds(const ClockDatagram& d) {
  const bool question = d.kind == ClockDatagramKind::kQuestion;
  const bool stamped =
      d.received_by_kernel || d.answered_by_kernel || d.received_ns != 0 || d.answered_ns != 0;
  return 1 <= d.node && d.node <= kLastNode && 0 <= d.number && d.number <= kIndexLimit &&
         is_clock(d.received_ns) && is_clock(d.answered_ns) && !(question && stamped);
}

}  // namespace

std::array<std::uint8_t, kClockDatagramBytes> encode(const ClockDatagram& d) {
  std::array<std::uint8_t, kClockDatagramBytes> bytes{};
  std::copy(kBegin.begin(), kBegin.end(), bytes.begin());
  bytes[kKind] = static_cast<std::uint8_t>(d.kind);
  bytes[kStamps] = static_cast<std::uint8_t>((d.received_by_kernel ? 1 : 0) | (d.answered_by_kernel ? 2 : 0));
  store(d.node, &bytes[kNode]);
  store(d.epoch, &bytes[kEpoch]);
  store(d.number, &bytes[kNumber]);
  store(d.received_ns, &bytes[kReceived]);
  store(d.answered_ns, &bytes[kAnswered]);
  store(crc32c(std::span(bytes).first<kCrc>()), &bytes[kCrc]);
  return bytes;
}

std::optional<ClockDatagram> decode_clock_datagram(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kClockDatagramBytes || !std::equal(kBegin.begin(), kBegin.end(), bytes.begin()) ||
      !ends_with_its_crc(bytes))
    return std::nullopt;
  const std::uint8_t kind = bytes[kKind], stamps = bytes[kStamps];
  if (kind < 1 || kind > 3 || stamps > 3 || bytes[kZero] != 0) return std::nullopt;
  const ClockDatagram d{.kind = static_cast<ClockDatagramKind>(kind),
                        .received_by_kernel = (stamps & 1) != 0,
                        .answered_by_kernel = (stamps & 2) != 0,
                        .node = load<std::int32_t>(&bytes[kNode]),
                        .epoch = load<std::int64_t>(&bytes[kEpoch]),
                        .number = load<std::int64_t>(&bytes[kNumber]),
                        .received_ns = load<std::int64_t>(&bytes[kReceived]),
                        .answered_ns = load<std::int64_t>(&bytes[kAnswered])};
  if (!in_bounds(d)) return std::nullopt;
  return d;
}

}  // namespace roadbalance

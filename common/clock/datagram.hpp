#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace roadbalance {

enum class ClockDatagramKind : std::uint8_t {
  kQuestion = 1,  ///< host -> node
  kAnswer = 2,    ///< node -> host; the stamp of its own sending was taken before it was sent
  kFollowUp =
      3,  ///< node -> host, behind the answer: the same with the kernel's stamp of the answer's sending
};

/// The datagrams that compare two clocks over UDP.  All kinds are equally long, so that no sender gets more
/// bytes out of a node than it sends, but for the follow-up.
///
/// Big endian: "RBCK", version 1, kind, kernel stamps (bit 0: received, bit 1: answered), 0, node (32 bit),
/// epoch, number, received_ns, answered_ns (64 bit each), CRC-32C of all before.  A question has no stamps.
struct ClockDatagram {
  ClockDatagramKind kind = ClockDatagramKind::kQuestion;
  bool received_by_kernel = false;
  bool answered_by_kernel = false;
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t number = 0;       ///< of the question
  std::int64_t received_ns = 0;  ///< node clock
  std::int64_t answered_ns = 0;  ///< node clock

  bool operator==(const ClockDatagram&) const = default;
};

inline constexpr std::size_t kClockDatagramBytes = 48;

std::array<std::uint8_t, kClockDatagramBytes> encode(const ClockDatagram& datagram);

/// Bytes from outside: refuses wrong size, magic, version, kind, CRC and anything out of bounds.
std::optional<ClockDatagram> decode_clock_datagram(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance

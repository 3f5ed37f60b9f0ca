#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace roadbalance {

/// A stretch of a recording's time, in ns as the recording tells time (EpochClock); the end is not included.
struct Piece {
  static constexpr std::int64_t kEver = std::numeric_limits<std::int64_t>::max();

  std::int64_t from_ns = 0;
  std::int64_t to_ns = kEver;  ///< kEver: to the end, whenever that is

  bool operator==(const Piece&) const = default;
};

/// Ascending; none begins before the one before it has ended.
using Pieces = std::vector<Piece>;

/// Number of the first piece that ends behind an instant: the one it lies in, or the next.
std::size_t piece_from(const Pieces& pieces, std::int64_t time_ns);
/// Number of the piece that an instant lies in.
std::optional<std::size_t> piece_at(const Pieces& pieces, std::int64_t time_ns);

/// What lies in both.
Pieces common_of(const Pieces& a, const Pieces& b);
/// What of `pieces` lies in none of `others`.
Pieces without(const Pieces& pieces, const Pieces& others);
/// Adds a piece that begins no earlier than the last one; what touches or overlaps becomes one.
void append(Pieces& pieces, const Piece& piece);
/// In order, of pieces in any.
Pieces merged(Pieces pieces);

}  // namespace roadbalance

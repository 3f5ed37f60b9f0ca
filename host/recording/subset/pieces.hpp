#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace roadbalance {

/// A stretch of a recording's time, in ns of its clock (EpochClock); the end is not included.
struct Piece {
  static constexpr std::int64_t kEver = std::numeric_limits<std::int64_t>::max();

  std::int64_t from_ns = 0;
  std::int64_t to_ns = kEver;  ///< kEver: to the end, whenever that is

  bool operator==(const Piece&) const = default;
};

/// Ascending; none begins before the one before it has ended.
using Pieces = std::vector<Piece>;

/// Number of the first piece that ends behind an instant: the piece around it, or the next.
std::size_t piece_from(const Pieces& pieces, std::int64_t time_ns);
/// Number of the piece around an instant.
std::optional<std::size_t> piece_at(const Pieces& pieces, std::int64_t time_ns);

/// The intersection.
Pieces common_of(const Pieces& a, const Pieces& b);
/// The parts of `pieces` outside all of `others`.
Pieces without(const Pieces& pieces, const Pieces& others);
/// Adds a piece that begins no earlier than the last one; pieces that touch or overlap become one.
void append(Pieces& pieces, const Piece& piece);
/// Sorts pieces and joins those that touch or overlap.
Pieces merged(Pieces pieces);

}  // namespace roadbalance

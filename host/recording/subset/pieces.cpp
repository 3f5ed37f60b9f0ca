#include "host/recording/subset/pieces.hpp"

#include <algorithm>

namespace roadbalance {

std::size_t piece_from(const Pieces& pieces, std::int64_t time_ns) {
  const auto found =
      std::upper_bound(pieces.begin(), pieces.end(), time_ns,
                       [](std::int64_t time, const Piece& piece) { return time < piece.to_ns; });
  return static_cast<std::size_t>(found - pieces.begin());
}

std::optional<std::size_t> piece_at(const Pieces& pieces, std::int64_t time_ns) {
  const std::size_t found = piece_from(pieces, time_ns);
  if (found == pieces.size() || time_ns < pieces[found].from_ns) return std::nullopt;
  return found;
}

Pieces common_of(const Pieces& a, const Pieces& b) {
  Pieces both;
  for (auto one = a.begin(), other = b.begin(); one != a.end() && other != b.end();) {
    const Piece piece{std::max(one->from_ns, other->from_ns), std::min(one->to_ns, other->to_ns)};
    if (piece.from_ns < piece.to_ns) both.push_back(piece);
    ++(one->to_ns < other->to_ns ? one : other);
  }
  return both;
}

Pieces without(const Pieces& pieces, const Pieces& others) {
  Pieces outside;
  std::int64_t from_ns = std::numeric_limits<std::int64_t>::min();
  for (const Piece& other : others) {
    if (from_ns < other.from_ns) outside.push_back({from_ns, other.from_ns});
    from_ns = other.to_ns;
  }
  if (from_ns < Piece::kEver) outside.push_back({from_ns, Piece::kEver});
  return common_of(pieces, outside);
}

void append(Pieces& pieces, const Piece& piece) {
  if (!pieces.empty() && piece.from_ns <= pieces.back().to_ns)
    pieces.back().to_ns = std::max(pieces.back().to_ns, piece.to_ns);
  else
    pieces.push_back(piece);
}

Pieces merged(Pieces pieces) {
  std::sort(pieces.begin(), pieces.end(),
            [](const Piece& a, const Piece& b) { return a.from_ns < b.from_ns; });
  Pieces in_order;
  for (const Piece& piece : pieces) append(in_order, piece);
  return in_order;
}

}  // namespace roadbalance

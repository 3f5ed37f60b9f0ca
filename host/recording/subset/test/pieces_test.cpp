#include "host/recording/subset/pieces.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace roadbalance {
namespace {

constexpr std::int64_t kInstants = 60;

Pieces by_chance(std::mt19937& random) {
  Pieces pieces;
  for (std::int64_t at = 0; at < kInstants;) {
    const auto from = at + static_cast<std::int64_t>(random() % 9),
               to = from + 1 + static_cast<std::int64_t>(random() % 9);
    pieces.push_back({from, to});
    at = to + 1;
  }
  if (random() % 2 == 0) pieces.back().to_ns = Piece::kEver;
  return pieces;
}

bool is_in(const Pieces& pieces, std::int64_t time_ns) {
  return std::any_of(pieces.begin(), pieces.end(),
                     [&](const Piece& piece) { return piece.from_ns <= time_ns && time_ns < piece.to_ns; });
}

TEST(Pieces, HoldTheInstantsThatTheirSetsHold) {
  std::mt19937 random(1);
  for (int run = 0; run < 500; ++run) {
    const Pieces a = by_chance(random), b = by_chance(random);
    const Pieces both = common_of(a, b), rest = without(a, b);
    Pieces any = a;
    any.insert(any.end(), b.begin(), b.end());
    std::shuffle(any.begin(), any.end(), random);
    any = merged(any);
    for (std::int64_t t = -1; t < 2 * kInstants; ++t) {
      EXPECT_EQ(is_in(both, t), is_in(a, t) && is_in(b, t)) << t;
      EXPECT_EQ(is_in(rest, t), is_in(a, t) && !is_in(b, t)) << t;
      EXPECT_EQ(is_in(any, t), is_in(a, t) || is_in(b, t)) << t;
      const auto found = piece_at(a, t);
      EXPECT_EQ(found.has_value(), is_in(a, t)) << t;
      if (found) {
        EXPECT_TRUE(is_in({a[*found]}, t)) << t;
      }
    }
    for (const Pieces& pieces : {both, rest, any})
      for (std::size_t k = 1; k < pieces.size(); ++k) EXPECT_LE(pieces[k - 1].to_ns, pieces[k].from_ns);
  }
}

}  // namespace
}  // namespace roadbalance

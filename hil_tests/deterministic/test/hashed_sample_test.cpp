#include "hil_tests/deterministic/hashed_sample.hpp"

#include <gtest/gtest.h>

#include "sim/random.hpp"

namespace roadbalance::test {
namespace {

TEST(HashedScans, AreTheRandomSequenceOfTheirPlace) {
  for (const std::int32_t node : {1, 4, 9999})
    for (const std::int64_t epoch : {std::int64_t{1}, std::int64_t{0x7EDCBA9876543210}}) {
      const HashedScans scans(node, epoch);
      for (const std::int64_t index : {std::int64_t{0}, std::int64_t{1}, std::int64_t{1} << 40}) {
        const auto row = scans.at(index);
        for (std::size_t channel = 0; channel < row.size(); ++channel) {
          const sim::RandomSequence sequence(static_cast<std::uint64_t>(epoch), sim::Use::kTestSample,
                                             static_cast<std::uint64_t>(node) * 16 + channel);
          EXPECT_EQ(row[channel], static_cast<std::int32_t>(sequence.bits(index) >> 40) - (1 << 23));
        }
      }
    }
}

TEST(HashedScans, FilledAtOnceAreThoseOfEachPlace) {
  const HashedScans scans(3, 0x1234567890ABCDE);
  for (const std::int64_t first : {std::int64_t{0}, std::int64_t{7}, (std::int64_t{1} << 40) - 2}) {
    for (const std::size_t count : {0, 1, 6, 19}) {
      std::array<HashedScans::Row, 20> rows{};
      scans.fill(first, std::span(rows).first(count));
      for (std::size_t k = 0; k < count; ++k)
        EXPECT_EQ(rows[k], scans.at(first + static_cast<std::int64_t>(k)));
      EXPECT_EQ(rows[count], HashedScans::Row{});
    }
  }
}

}  // namespace
}  // namespace roadbalance::test

#include "common/types/crc32c.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <string_view>
#include <vector>

namespace roadbalance {
namespace {

std::vector<std::uint8_t> filled(std::uint8_t value) {
  return std::vector<std::uint8_t>(32, value);
}

// RFC 3720, appendix B.4; the CRCs are printed there with the first byte on the wire first.
TEST(Crc32c, GivesTheVectorsOfRfc3720) {
  std::vector<std::uint8_t> rising(32), falling(32);
  std::iota(rising.begin(), rising.end(), std::uint8_t{0});
  std::iota(falling.rbegin(), falling.rend(), std::uint8_t{0});
  for (const auto& crc : {&crc32c, &crc32c_by_table}) {
    EXPECT_EQ(crc(filled(0x00), 0), 0x8A9136AAu);
    EXPECT_EQ(crc(filled(0xFF), 0), 0x62A8AB43u);
    EXPECT_EQ(crc(rising, 0), 0x46DD794Eu);
    EXPECT_EQ(crc(falling, 0), 0x113FDB5Cu);
  }
}

// The check value of the CRC-32/ISCSI catalogue entry.
TEST(Crc32c, GivesTheCatalogueCheckValue) {
  constexpr std::string_view kCheck = "123456789";
  const std::vector<std::uint8_t> bytes(kCheck.begin(), kCheck.end());
  EXPECT_EQ(crc32c(bytes), 0xE3069283u);
}

TEST(Crc32c, InstructionAndTableAgreeForEveryLengthAndOffset) {
  if (!crc32c_has_instruction())
    GTEST_SKIP() << "this processor has no CRC instruction: there is only the table";
  std::mt19937 random(1);
  std::vector<std::uint8_t> bytes(2800);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  // 1344 and 2688 bytes are one and two rounds of the three lanes.
  const auto is_near_lanes = [](std::size_t length) { return length % 1344 > 1320 || length % 1344 < 70; };
  for (std::size_t length = 0; length < 2760; length += (is_near_lanes(length) ? 1 : 7)) {
    for (std::size_t offset = 0; offset < 8; ++offset) {
      const std::span<const std::uint8_t> part(bytes.data() + offset, length);
      ASSERT_EQ(crc32c(part), crc32c_by_table(part)) << length << " bytes from " << offset;
    }
  }
}

TEST(Crc32c, OfColumnsIsThatOfEachColumnAlone) {
  std::mt19937 random(2);
  for (const std::size_t columns : {1, 3, 6, 16}) {
    std::vector<std::uint8_t> rows(columns * 4 * 20);
    for (auto& byte : rows) byte = static_cast<std::uint8_t>(random());
    for (const auto& function : {&crc32c_columns, &crc32c_columns_by_table}) {
      std::vector<std::uint32_t> crc(columns, 0);
      const std::size_t five_rows = columns * 4 * 5;
      function(std::span(rows).first(five_rows), crc);
      function(std::span(rows).subspan(five_rows), crc);
      for (std::size_t column = 0; column < columns; ++column) {
        std::vector<std::uint8_t> alone;
        for (std::size_t at = 4 * column; at < rows.size(); at += 4 * columns)
          alone.insert(alone.end(), rows.begin() + static_cast<std::ptrdiff_t>(at),
                       rows.begin() + static_cast<std::ptrdiff_t>(at) + 4);
        EXPECT_EQ(crc[column], crc32c_by_table(alone)) << column << " of " << columns;
      }
    }
  }
}

TEST(Crc32c, ContinuesWhereAnEarlierPartEnded) {
  std::vector<std::uint8_t> bytes(100);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{7});
  const std::span<const std::uint8_t> all(bytes);
  EXPECT_EQ(crc32c(all.subspan(33), crc32c(all.first(33))), crc32c(all));
}

}  // namespace
}  // namespace roadbalance

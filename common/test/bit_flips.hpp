#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace roadbalance::test {

/// `decode` takes the message as it is, and refuses it with any single bit turned or with a byte less.
template <typename Decode>
void expect_every_bit_flip_refused(std::vector<std::uint8_t> bytes, Decode decode) {
  ASSERT_TRUE(decode(bytes));
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << (bit % 8));
    ASSERT_FALSE(decode(bytes)) << "bit " << bit;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << (bit % 8));
  }
  bytes.pop_back();
  EXPECT_FALSE(decode(bytes));
}

}  // namespace roadbalance::test

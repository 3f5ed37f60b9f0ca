#include "common/dbc/can_signal.hpp"

#include <cmath>
#include <initializer_list>
#include <random>

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

CanFrame frame(std::initializer_list<std::uint8_t> bytes) {
  CanFrame f{.size = static_cast<std::uint8_t>(bytes.size())};
  std::copy(bytes.begin(), bytes.end(), f.data.begin());
  return f;
}

/// The signal's value in the frame; nothing if it is too short.
std::optional<double> value_of(const CanSignal& signal, const CanFrame& f) {
  const auto bits = signal.bits(f);
  if (!bits) return std::nullopt;
  return signal.value(signal.raw(*bits));
}

TEST(CanSignal, FollowsTheBitNumberingOfBothByteOrders) {
  const CanFrame f = frame({0x01, 0x23, 0x45, 0x67, 0x89, 0xAB, 0xCD, 0xEF});
  const auto value = [&](ByteOrder order, int start, int length) {
    return value_of(CanSignal{.order = order, .start_bit = start, .length = length}, f).value();
  };
  EXPECT_EQ(value(ByteOrder::kBigEndian, 7, 16), 0x0123);
  EXPECT_EQ(value(ByteOrder::kLittleEndian, 0, 16), 0x2301);
  EXPECT_EQ(value(ByteOrder::kBigEndian, 3, 12), 0x123);  // across a byte, from its middle
  EXPECT_EQ(value(ByteOrder::kLittleEndian, 4, 12), 0x230);
  EXPECT_EQ(value(ByteOrder::kBigEndian, 56, 1), 1);
  EXPECT_EQ(value(ByteOrder::kBigEndian, 7, 64), std::ldexp(0x01234567, 32) + 0x89ABCDEF);
}

TEST(CanSignal, WritesTheBytesOfExamplesWorkedOutByHand) {
  CanFrame f{.size = 4};
  // 12 bits 0xABC from bit 3 of byte 1 down: A fills its low half, BC byte 2.
  ASSERT_TRUE((CanSignal{.start_bit = 11, .length = 12}.put(0xABC, f)));
  EXPECT_EQ(f.data[0], 0x00);
  EXPECT_EQ(f.data[1], 0x0A);
  EXPECT_EQ(f.data[2], 0xBC);
  // The same 12 bits from bit 4 of byte 0 up: C in its high half, AB in byte 1, which is overwritten.
  ASSERT_TRUE((CanSignal{.order = ByteOrder::kLittleEndian, .start_bit = 4, .length = 12}.put(0xABC, f)));
  EXPECT_EQ(f.data[0], 0xC0);
  EXPECT_EQ(f.data[1], 0xAB);
  EXPECT_EQ(f.data[2], 0xBC);
  // 36.0 km/h at 0.01 km/h from -67.67 are (36 + 67.67) / 0.01 = 10367 = 0x287F.
  ASSERT_TRUE((CanSignal{.start_bit = 7, .length = 16, .scale = 0.01, .offset = -67.67}.put(36.0, f)));
  EXPECT_EQ(f.data[0], 0x28);
  EXPECT_EQ(f.data[1], 0x7F);
  // -2.5 as IEEE 754 single precision is 0xC0200000.
  ASSERT_TRUE(
      (CanSignal{.order = ByteOrder::kLittleEndian, .start_bit = 0, .length = 32, .number = CanNumber::kFloat}
           .put(-2.5, f)));
  EXPECT_EQ(f.data[3], 0xC0);
  EXPECT_EQ(f.data[2], 0x20);
}

TEST(CanSignal, ReadsNegativeNumbers) {
  const CanSignal signal{
      .start_bit = 7, .length = 12, .number = CanNumber::kSigned, .scale = 0.5, .offset = 1.0};
  EXPECT_EQ(value_of(signal, frame({0xFF, 0xF0})).value(), 0.5);
  EXPECT_EQ(value_of(signal, frame({0x80, 0x00})).value(), -1'023.0);
  EXPECT_EQ(value_of(signal, frame({0x7F, 0xF0})).value(), 1'024.5);
  const CanSignal wide{
      .order = ByteOrder::kLittleEndian, .start_bit = 0, .length = 64, .number = CanNumber::kSigned};
  EXPECT_EQ(value_of(wide, frame({0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF})).value(), -2.0);
}

TEST(CanSignal, ReadsFloats) {
  const CanSignal one{.start_bit = 7, .length = 32, .number = CanNumber::kFloat, .scale = 2.0};
  EXPECT_EQ(value_of(one, frame({0x40, 0x49, 0x0F, 0xDB})).value(), 2.0 * static_cast<double>(3.14159274f));
  const CanSignal two{
      .order = ByteOrder::kLittleEndian, .start_bit = 0, .length = 64, .number = CanNumber::kDouble};
  EXPECT_EQ(value_of(two, frame({0, 0, 0, 0, 0, 0, 0xF8, 0xBF})).value(), -1.5);
}

TEST(CanSignal, ReachesTheLastByteOfALongFrame) {
  CanFrame f{.is_fd = true, .size = 64};
  f.data[62] = 0x12;
  f.data[63] = 0x34;
  EXPECT_EQ((value_of(CanSignal{.start_bit = 503, .length = 16}, f)), 0x1234);
  EXPECT_EQ((value_of(CanSignal{.order = ByteOrder::kLittleEndian, .start_bit = 496, .length = 16}, f)),
            0x3412);
  EXPECT_FALSE((value_of(CanSignal{.start_bit = 511, .length = 16}, f)));
}

TEST(CanSignal, IsNotThereInAShortFrame) {
  const CanSignal signal{.start_bit = 7, .length = 16};
  EXPECT_TRUE(value_of(signal, frame({1, 2})));
  CanFrame shorter = frame({1});
  EXPECT_FALSE(value_of(signal, shorter));
  EXPECT_FALSE(signal.put(5, shorter));
  EXPECT_EQ(shorter.data[0], 1);
  EXPECT_FALSE(value_of(signal, frame({})));
  EXPECT_FALSE((value_of(CanSignal{.start_bit = 64, .length = 1}, frame({1, 2, 3, 4, 5, 6, 7, 8}))));
  EXPECT_FALSE((value_of(CanSignal{.start_bit = -1, .length = 1}, frame({1}))));
  EXPECT_FALSE((value_of(CanSignal{.length = 0}, frame({1}))));
  EXPECT_FALSE((value_of(CanSignal{.length = 65}, frame({1}))));
}

TEST(CanSignal, RefusesToSayWhatItsBitsCannot) {
  CanFrame f{.size = 8};
  const CanSignal byte{};
  EXPECT_TRUE(byte.put(255.4, f));
  EXPECT_EQ(f.data[0], 255);
  EXPECT_FALSE(byte.put(255.6, f));
  EXPECT_FALSE(byte.put(-0.6, f));
  EXPECT_FALSE(byte.put(std::nan(""), f));
  const CanSignal negative{.number = CanNumber::kSigned};
  EXPECT_TRUE(negative.put(-128, f));
  EXPECT_EQ(f.data[0], 0x80);
  EXPECT_FALSE(negative.put(128, f));
  EXPECT_FALSE((CanSignal{.length = 32, .number = CanNumber::kFloat}.put(1e39, f)));
  EXPECT_FALSE((CanSignal{.length = 64}.put(std::ldexp(1.0, 64), f)));
  EXPECT_TRUE((CanSignal{.length = 64}.put(std::ldexp(1.0, 63), f)));
}

/// An independent reading: the frame as one long number, first byte highest (Motorola) or lowest (Intel).
std::uint64_t bits_of(const CanSignal& signal, const CanFrame& f) {
  std::uint64_t bits = 0;
  const bool big = signal.order == ByteOrder::kBigEndian;
  for (int n = 0; n < signal.length; ++n) {
    // Along the number whose first byte is highest, bit j of byte i is place 8 i + 7 - j.
    const int along = big ? signal.start_bit / 8 * 8 + 7 - signal.start_bit % 8 + n : signal.start_bit + n;
    const int shift = big ? 7 - along % 8 : along % 8;
    const std::uint64_t one = f.data[static_cast<std::size_t>(along / 8)] >> shift & 1U;
    bits |= one << (big ? signal.length - 1 - n : n);
  }
  return bits;
}

TEST(CanSignal, ReadsBackWhatItWroteAndChangesNothingElse) {
  std::mt19937 random(1);
  const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
  int checked = 0;
  for (int turn = 0; turn < 20'000; ++turn) {
    constexpr CanNumber kKinds[] = {CanNumber::kUnsigned, CanNumber::kSigned, CanNumber::kFloat,
                                    CanNumber::kDouble};
    CanSignal signal{.order = below(2) ? ByteOrder::kBigEndian : ByteOrder::kLittleEndian,
                     .start_bit = below(512),
                     .length = 1 + below(64),
                     .number = kKinds[below(4)],
                     .scale = std::ldexp(1.0 + below(7), below(20) - 15) * (below(2) ? 1 : -1),
                     .offset = below(2'001) - 1'000.0};
    if (signal.number == CanNumber::kFloat) signal.length = 32;
    if (signal.number == CanNumber::kDouble) signal.length = 64;
    if (!signal.fits(64)) continue;
    CanFrame f{.is_fd = true, .size = 64};
    for (auto& byte : f.data) byte = static_cast<std::uint8_t>(random());
    const CanFrame before = f;
    ASSERT_EQ(signal.bits(f), bits_of(signal, f));

    const std::uint64_t bits = (std::uint64_t{random()} << 32 | random()) >> (64 - signal.length);
    ASSERT_TRUE(signal.put_bits(bits, f));
    ASSERT_EQ(signal.bits(f), bits);
    const double value = value_of(signal, f).value();
    // Beyond 2^53 neighbouring counts are one double; other floats lose digits to the offset.
    if (signal.number == CanNumber::kUnsigned || signal.number == CanNumber::kSigned) {
      if (signal.length <= 40) {
        CanFrame again = before;
        ASSERT_TRUE(signal.put(value, again)) << turn;
        ASSERT_EQ(again.data, f.data) << turn;
      }
      ++checked;
    }
    ASSERT_TRUE(signal.put_bits(signal.bits(before).value(), f));
    ASSERT_EQ(f.data, before.data);
  }
  EXPECT_GT(checked, 5'000);
}

}  // namespace
}  // namespace roadbalance

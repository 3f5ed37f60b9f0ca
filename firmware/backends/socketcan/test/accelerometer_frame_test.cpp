#include "firmware/backends/socketcan/accelerometer_frame.hpp"

#include <gtest/gtest.h>

#include <random>

namespace roadbalance {
namespace {

constexpr std::uint32_t kFirst = 0x200;

TEST(AccelerometerFrame, LiesInAFrameOfCanFdAsDocumented) {
  AccelerometerFrame content{.sequence = 0x01020304, .part = {}, .overload = 0x801};
  content.sample[0] = -2;
  content.sample[11] = 0x1234;
  const CanFrame frame = write_accelerometer(content, kFirst);
  EXPECT_EQ(frame.id, kFirst);
  EXPECT_TRUE(frame.is_fd);
  ASSERT_EQ(frame.size, 32);
  const std::uint8_t head[] = {0x10, 0x00, 0x01, 0x08, 0x04, 0x03, 0x02, 0x01, 0xFE, 0xFF};
  for (std::size_t k = 0; k < sizeof head; ++k) EXPECT_EQ(frame.data[k], head[k]) << k;
  EXPECT_EQ(frame.data[30], 0x34);
  EXPECT_EQ(frame.data[31], 0x12);
}

TEST(AccelerometerFrame, LiesInFramesOfClassicCanAsDocumented) {
  AccelerometerFrame content{.sequence = 0xABCD, .part = 2, .overload = 0b001'010'100'000};
  content.sample[6] = 1;
  content.sample[8] = -32'768;
  const CanFrame frame = write_accelerometer(content, kFirst);
  EXPECT_EQ(frame.id, kFirst + 2);
  EXPECT_FALSE(frame.is_fd);
  ASSERT_EQ(frame.size, 8);
  const std::uint8_t bytes[] = {0x12, 0xCD, 0x01, 0x00, 0x00, 0x00, 0x00, 0x80};
  for (std::size_t k = 0; k < sizeof bytes; ++k) EXPECT_EQ(frame.data[k], bytes[k]) << k;
}

TEST(AccelerometerFrame, IsReadBackAsItWasWritten) {
  std::mt19937 random(3);
  for (int turn = 0; turn < 1'000; ++turn) {
    AccelerometerFrame content{.sequence = static_cast<std::uint32_t>(random()), .part = {}};
    content.overload = random() & 0xFFF;
    for (auto& sample : content.sample) sample = static_cast<std::int16_t>(random());
    const auto whole = read_accelerometer(write_accelerometer(content, kFirst), kFirst);
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->sequence, content.sequence);
    EXPECT_EQ(whole->overload, content.overload);
    EXPECT_EQ(whole->sample, content.sample);
    for (int part = 0; part < 4; ++part) {
      content.part = part;
      const auto read = read_accelerometer(write_accelerometer(content, kFirst), kFirst);
      ASSERT_TRUE(read);
      EXPECT_EQ(read->part, part);
      EXPECT_EQ(read->sequence, content.sequence & 0xFF);
      EXPECT_EQ(read->overload, content.overload & 0x7 << 3 * part);
      for (std::size_t k = 0; k < 12; ++k)
        EXPECT_EQ(read->sample[k], static_cast<int>(k / 3) == part ? content.sample[k] : 0);
    }
  }
}

TEST(AccelerometerFrame, RefusesWhatIsNotOfItsLayout) {
  const CanFrame whole = write_accelerometer({.part = {}}, kFirst);
  const CanFrame part = write_accelerometer({.part = 3}, kFirst);
  ASSERT_TRUE(read_accelerometer(whole, kFirst));
  ASSERT_TRUE(read_accelerometer(part, kFirst));
  const auto refused = [](CanFrame frame, auto change) {
    change(frame);
    return !read_accelerometer(frame, kFirst);
  };
  EXPECT_TRUE(refused(whole, [](CanFrame& f) { f.data[0] = 0x20; }));  // another version
  EXPECT_TRUE(refused(part, [](CanFrame& f) { f.data[0] = 0x20; }));
  EXPECT_TRUE(refused(whole, [](CanFrame& f) { f.data[0] = 0x11; }));  // bits that are 0 in this version
  EXPECT_TRUE(refused(whole, [](CanFrame& f) { f.data[1] = 1; }));
  EXPECT_TRUE(refused(whole, [](CanFrame& f) { f.data[3] = 0x10; }));
  EXPECT_TRUE(refused(part, [](CanFrame& f) { f.data[0] = 0x18; }));
  EXPECT_TRUE(refused(whole, [](CanFrame& f) { f.size = 24; }));
  EXPECT_TRUE(refused(part, [](CanFrame& f) { f.size = 7; }));
  EXPECT_TRUE(refused(whole, [](CanFrame& f) { f.id = kFirst + 1; }));
  EXPECT_TRUE(refused(part, [](CanFrame& f) { f.id = kFirst + 4; }));
  EXPECT_TRUE(refused(part, [](CanFrame& f) { f.id = kFirst - 1; }));
  EXPECT_TRUE(refused(part, [](CanFrame& f) { f.extended = true; }));
}

}  // namespace
}  // namespace roadbalance

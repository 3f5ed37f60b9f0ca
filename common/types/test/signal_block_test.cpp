#include <gtest/gtest.h>

#include "common/types/blocks.hpp"

namespace roadbalance {
namespace {

SignalSample sample_at(std::int64_t ns, std::uint16_t signal = 0, double value = 0.0) {
  return {.time = node_time_from_ns(ns), .signal = signal, .value = value};
}

// Two devices give theirs in turns: only the samples of one signal are in order of time.
TEST(SignalBlock, GivesBackTheSamplesThatWereAddedAsTheyCame) {
  SignalBlock block;
  EXPECT_TRUE(block.empty());
  std::vector<SignalSample> added;
  for (int k = 0; k < kSamplesPerBlock; ++k) {
    added.push_back(sample_at(9'876'543'210'123 + (k & 1 ? -40'000'000L : 10'000'000L) * k,
                              static_cast<std::uint16_t>(k & 1 ? kMostSignals - 1 : k), -0.1 * k));
    ASSERT_TRUE(block.add(added.back()));
    EXPECT_FALSE(block.empty());
  }
  EXPECT_EQ(block.header.time_ns, 9'876'543'210'123);
  const auto samples = block.unpack();
  ASSERT_EQ(samples.size(), added.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    EXPECT_EQ(samples[k].time, added[k].time);
    EXPECT_EQ(samples[k].signal, added[k].signal);
    EXPECT_EQ(samples[k].value, added[k].value);
  }
}

TEST(SignalBlock, TakesNoMoreThanFitsIntoADatagram) {
  SignalBlock block;
  for (int k = 0; k < kSamplesPerBlock; ++k) ASSERT_TRUE(block.add(sample_at(k)));
  EXPECT_FALSE(block.add(sample_at(kSamplesPerBlock)));
  EXPECT_EQ(block.samples, kSamplesPerBlock);
  EXPECT_EQ(block.unpack().back().time, node_time_from_ns(kSamplesPerBlock - 1));
}

}  // namespace
}  // namespace roadbalance

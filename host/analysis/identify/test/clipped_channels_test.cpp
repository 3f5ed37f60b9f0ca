#include "host/analysis/identify/clipped_channels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace roadbalance {
namespace {

constexpr double kScale = 50.0 / kFullScaleCounts;

NodeConfig node() {
  NodeConfig node{"front", 1, 2000.0, {}};
  for (const char* name : {"left_z", "left_x", "nothing", "right_z"}) {
    ChannelConfig channel;
    channel.name = name;
    channel.range_m_s2 = 50.0;
    channel.scale_m_s2_per_count = kScale;
    if (channel.name == "nothing") channel.role = ChannelRole::kUnused;
    node.channel.push_back(channel);
  }
  return node;
}

/// Noise of 15 Hz and 6 m/s^2 rms on all channels; those of `cut` are clipped at 10 m/s^2.
class Drive {
 public:
  explicit Drive(std::int32_t cut) : cut_(cut) {}

  ScanBlock next() {
    ScanBlock block;
    block.header = {.node = 1, .epoch = epoch, .first_scan = scan, .scans = kScansPerBlock};
    block.period_ps = 500'000'000;
    for (auto& row : block.counts)
      for (std::size_t c = 0; c < 4; ++c) {
        // A resonance at 15 Hz, a tenth of critically damped.
        constexpr double kOmega = 2.0 * 3.14159265 * 15.0 / 2000.0;
        speed_[c] += -0.2 * kOmega * speed_[c] - kOmega * kOmega * value_[c] + 0.04 * normal_(random_);
        value_[c] += speed_[c];
        const double limit_m_s2 = (cut_ >> c & 1) != 0 ? 10.0 : 1e9;
        row[c] = static_cast<std::int32_t>(std::clamp(value_[c], -limit_m_s2, limit_m_s2) / kScale);
      }
    scan += kScansPerBlock;
    return block;
  }

  std::int64_t epoch = 7, scan = 0;

 private:
  std::int32_t cut_;
  std::mt19937_64 random_{3};
  std::normal_distribution<double> normal_;
  std::array<double, 4> speed_{}, value_{};
};

TEST(ClippedChannels, NamesTheClippedOnesAndTheBlocksInWhichTheyWere) {
  ClippedChannels watch(node());
  Drive drive(0b1101);
  std::int32_t news = 0, reached = 0;
  int blocks = 0, wrong = 0, told = 0;
  for (; blocks < 6000; ++blocks) {
    const ScanBlock block = drive.next();
    const auto found = watch.add(block);
    told += found.news != 0;
    news |= found.news;
    reached |= found.reached;
    if (news != 0b1001) continue;
    for (const std::size_t c : {0U, 3U}) {
      const bool at =
          std::ranges::any_of(block.counts, [&](const auto& row) { return row[c] * kScale > 9.99; });
      if (at && (found.reached >> c & 1) == 0) ++wrong;
    }
  }
  EXPECT_EQ(news, 0b1001) << "the unused one is not watched, the other not clipped";
  EXPECT_EQ(reached, news);
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(told, 4) << "each side of two channels once";
  const auto sentences = watch.sentences();
  ASSERT_EQ(sentences.size(), 2U);
  EXPECT_EQ(sentences[0].find("left_z is clipped at +10.0 and -10.0 m/s², though its range is 50 m/s²: "), 0U)
      << sentences[0];
  EXPECT_EQ(sentences[1].find("right_z is clipped at "), 0U);
}

TEST(ClippedChannels, AHoleChangesNothingAndAnEpochAll) {
  ClippedChannels watch(node(), 0b0001);
  Drive drive(0b1001);
  for (int k = 0; k < 6000; ++k) watch.add(drive.next());
  ASSERT_EQ(watch.sentences().size(), 1U) << "the other is not watched";
  drive.scan += 1000;
  watch.add(drive.next());
  EXPECT_EQ(watch.sentences().size(), 1U);
  drive.epoch = 8;
  EXPECT_EQ(watch.add(drive.next()).reached, 0);
  EXPECT_TRUE(watch.sentences().empty());
}

TEST(ClippedClause, TellsWhetherTheLimitIsThatOfTheRange) {
  const ChannelConfig channel = node().channel[0];
  const auto counts = [](double m_s2) { return static_cast<std::int32_t>(std::lround(m_s2 / kScale)); };
  EXPECT_EQ(clipped_clause(channel, {}), std::nullopt);
  EXPECT_EQ(clipped_clause(channel, {.low = counts(-24.66), .high = {}}),
            "is clipped at -25 m/s², though its range is 50 m/s²");
  EXPECT_EQ(clipped_clause(channel, {.low = {}, .high = counts(49.9)}),
            "is clipped at +50 m/s², the end of its range of 50 m/s²");
}

}  // namespace
}  // namespace roadbalance

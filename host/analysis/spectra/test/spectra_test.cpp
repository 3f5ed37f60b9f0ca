#include "host/analysis/spectra/spectra.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace roadbalance {
namespace {

constexpr double kRate_hz = 1000.0;
constexpr double kScale = 1e-4;

NodeConfig node() {
  NodeConfig node{"front", 4, kRate_hz, {}};
  for (const char* name : {"tone", "noise"}) {
    ChannelConfig channel;
    channel.name = name;
    channel.scale_m_s2_per_count = kScale;
    node.channel.push_back(channel);
  }
  return node;
}

/// A tone of 3 m/s^2 at 40 Hz on channel 0, white noise of 1 m/s^2 rms on channel 1.
class Source {
 public:
  ScanBlock next() {
    ScanBlock block;
    block.header = {4, 1, ++sequence_, scan_, kScansPerBlock, scan_ * 1'000'000};
    block.period_ps = 1'000'000'000;
    for (auto& row : block.counts) {
      const double t = static_cast<double>(scan_++) / kRate_hz;
      row[0] =
          static_cast<std::int32_t>(std::lround(3.0 / kScale * std::sin(2.0 * std::numbers::pi * 40.0 * t)));
      row[1] = static_cast<std::int32_t>(std::lround(normal_(random_) / kScale));
    }
    return block;
  }

 private:
  std::int64_t scan_ = 0;
  std::int64_t sequence_ = 0;
  std::mt19937 random_{5};
  std::normal_distribution<double> normal_;
};

/// The parts of a channel put together again.
std::vector<double> whole(const std::vector<SpectrumPart>& parts, int channel) {
  std::vector<double> density;
  for (const auto& part : parts) {
    if (part.channel != channel) continue;
    EXPECT_NEAR(part.first_hz, static_cast<double>(density.size()) * part.step_hz, 1e-9);
    EXPECT_LE(part.density.size(), static_cast<std::size_t>(kSpectrumBinsPerPart));
    density.insert(density.end(), part.density.begin(), part.density.end());
  }
  return density;
}

TEST(SpectrumMeter, PutsToneAndNoiseWhereTheyBelongInAcceleration) {
  SpectrumMeter meter(node());
  Source source;
  for (int i = 0; i < 600; ++i) meter.add(source.next());  // 12 s
  const auto parts = meter.take();
  ASSERT_FALSE(parts.empty());
  EXPECT_EQ(parts.front().node, 4);
  EXPECT_EQ(parts.front().time_ns, 12'000'000'000);
  EXPECT_DOUBLE_EQ(parts.front().step_hz, 0.5);
  EXPECT_EQ(parts.front().averages, 9);  // 10 s in segments of 2 s, half overlapping
  // 40 Hz lies on a bin: density times noise bandwidth is the mean square.
  const auto tone = whole(parts, 0);
  EXPECT_EQ(tone.size(), 501U);
  EXPECT_NEAR(tone[80] * parts.front().enbw_hz, 3.0 * 3.0 / 2.0, 1e-3);
  EXPECT_LT(tone[90], 1e-6);
  // One-sided density of white noise is variance / (rate / 2); 450 bins of some 5 independent averages each
  // give a mean within 4 / sqrt(450 * 5) = 8 %.
  const auto noise = whole(parts, 1);
  double mean = 0.0;
  for (std::size_t bin = 10; bin < 460; ++bin) mean += noise[bin] / 450.0;
  EXPECT_NEAR(mean, 1.0 / (kRate_hz / 2.0), 0.08 / (kRate_hz / 2.0));
}

TEST(SpectrumMeter, NeverAveragesAcrossAHole) {
  SpectrumMeter meter(node());
  Source source;
  for (int i = 0; i < 99; ++i) meter.add(source.next());
  source.next();  // lost
  EXPECT_TRUE(meter.take().empty());
  for (int i = 0; i < 99; ++i) meter.add(source.next());
  EXPECT_TRUE(meter.take().empty()) << "1.98 s and 1.98 s with a hole between are no segment of 2 s";
  meter.add(source.next());
  EXPECT_FALSE(meter.take().empty());
  EXPECT_TRUE(meter.take().empty()) << "nothing new";
}

TEST(SpectrumMeter, TellsNothingOfASegmentThatWasNotTakenBeforeAHole) {
  SpectrumMeter meter(node());
  Source source;
  for (int i = 0; i < 100; ++i) meter.add(source.next());
  source.next();  // lost
  meter.add(source.next());
  EXPECT_TRUE(meter.take().empty());
}

}  // namespace
}  // namespace roadbalance

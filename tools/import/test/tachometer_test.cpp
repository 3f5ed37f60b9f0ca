#include "tools/import/tachometer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "host/analysis/angle/recorded_angle.hpp"
#include "tools/import/test/import_fixture.hpp"

namespace roadbalance {
namespace {

constexpr double kPeriod_s = 1e-3;

struct Found {
  std::vector<double> time_s;
  double sigma_s, threshold;
};

Found pulses_of(const std::vector<double>& signal) {
  TachometerLevels levels;
  for (const double value : signal) levels.add(value);
  TachometerPulses pulses(levels);
  Found found{};
  for (std::size_t k = 0; k < signal.size(); ++k)
    if (const auto pulse = pulses.add(kPeriod_s * static_cast<double>(k), kPeriod_s, signal[k]))
      found.time_s.push_back(*pulse);
  found.sigma_s = pulses.sigma_s();
  found.threshold = pulses.threshold();
  EXPECT_EQ(pulses.pulses(), std::ssize(found.time_s));
  return found;
}

TEST(Tachometer, PulsesAreWhereAnAnalogueSignalRisesThroughItsMiddle) {
  // 3 + 2 sin(2 pi f t) rises through 3 at t = n / f.
  constexpr double kHz = 7.3;
  std::vector<double> signal;
  for (int k = 0; k < 2000; ++k)
    signal.push_back(3.0 + 2.0 * std::sin(2.0 * std::numbers::pi * kHz * kPeriod_s * k));
  const Found found = pulses_of(signal);
  EXPECT_NEAR(found.threshold, 3.0, 1e-4);  // between the samples nearest to the extremes
  ASSERT_EQ(found.time_s.size(), 14U);      // the first at 0 was not low before
  for (std::size_t n = 0; n < found.time_s.size(); ++n)
    // A line between samples beside an inflection is off by (2 pi f T)^2 / 15 of T at the most, the threshold
    // by 1e-4 of its slope 92 a second.
    EXPECT_NEAR(found.time_s[n], static_cast<double>(n + 1) / kHz, 2e-6);
  // In a period it rises by 2 * 2 pi f T = 0.0917 of its 4.
  EXPECT_NEAR(found.sigma_s, 0.0229 * kPeriod_s / std::sqrt(12.0), 0.0005 * kPeriod_s);
}

TEST(Tachometer, ASwitchIsKnownToASampleAndItsUncertaintyIsRight) {
  // A pulse of 0.13 of a turn; the phase between turns and samples wanders.
  constexpr double kHz = 51.03;
  std::vector<double> signal;
  for (int k = 0; k < 20'000; ++k)
    signal.push_back(std::fmod(kHz * kPeriod_s * k + 0.5, 1.0) < 0.13 ? 1.0 : 0.0);
  const Found found = pulses_of(signal);
  double square = 0.0;
  for (std::size_t n = 0; n < found.time_s.size(); ++n) {
    const double off_s = found.time_s[n] - (static_cast<double>(n) + 0.5) / kHz;
    EXPECT_LE(std::abs(off_s), 0.5001 * kPeriod_s) << n;
    square += off_s * off_s / static_cast<double>(found.time_s.size());
  }
  EXPECT_EQ(found.time_s.size(), 1021U);  // 0.5, 1.5 ... 1020.5 of 1020.6 turns
  EXPECT_NEAR(found.sigma_s, kPeriod_s / std::sqrt(12.0), 1e-9);
  EXPECT_NEAR(std::sqrt(square) / found.sigma_s, 1.0, 0.05);  // 1021 even ones: 1.4 %
}

TEST(Tachometer, NoiseWithinTheHysteresisMakesNoSecondPulse) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-0.2, 0.2);
  std::vector<double> signal;
  constexpr double kHz = 5.0;
  for (int k = 0; k < 9900; ++k)
    signal.push_back(std::sin(2.0 * std::numbers::pi * kHz * kPeriod_s * k) + noise(random));
  EXPECT_EQ(pulses_of(signal).time_s.size(), 49U);  // at 0.2, 0.4 ... 9.8 s
}

TEST(Tachometer, MissingSamplesMakeNoPulse) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(pulses_of({0, 0, 1, 1, 0, 0, 1}).time_s, (std::vector<double>{1.5e-3, 5.5e-3}));
  EXPECT_EQ(pulses_of({0, 0, 1, 1, 0, kNone, 1}).time_s, (std::vector<double>{1.5e-3}));
  TachometerPulses pulses({0.0, 1.0, 2});
  EXPECT_FALSE(pulses.add(0.0, kPeriod_s, 0.0));
  EXPECT_FALSE(pulses.add(5e-3, kPeriod_s, 1.0)) << "four samples are missing between";
}

TEST(Tachometer, NamesItsColumnAndWheel) {
  const auto column = TachometerColumn::parse("a=b=rear_left");
  EXPECT_EQ(column.channel, "a=b");
  EXPECT_EQ(column.wheel, 2);
  for (const char* const wrong : {"tachometer", "=front_left", "tachometer=fifth", "tachometer="})
    EXPECT_THROW(TachometerColumn::parse(wrong), ConfigError) << wrong;
}

/// The second node's wheel front_left by a tachometer of one pulse a turn.
class ImportTachometer : public ImportSamples {
 protected:
  static VehicleConfig vehicle() {
    VehicleConfig vehicle = two_nodes();
    vehicle.wheel[0].encoder.pulses_per_turn = 1;
    return vehicle;
  }
  static std::string with_tachometer(std::size_t rows, const std::function<double(std::size_t)>& signal) {
    std::string text = "time_s,second_up,first_up,tacho\ns,g,m/s^2,V\n";
    for (std::size_t i = 0; i < rows; ++i)
      text += std::to_string(uniform(i)) + ",0.1,0.2," + std::to_string(signal(i)) + "\n";
    return text;
  }
  ImportReport import(const std::string& text, const std::string& column, const std::string& into) {
    return import_samples({.samples = write("s.csv", text),
                           .tachometer = {TachometerColumn::parse(column)},
                           .folder = folder_ / into},
                          vehicle());
  }
  std::string refusal(const std::string& text, const std::string& column) {
    try {
      import(text, column, "refused");
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  }
  static double turning(std::size_t i) {
    return std::fmod(23.0 * static_cast<double>(i) / kRate_hz, 1.0) < 0.5 ? -1.0 : 4.0;
  }
};

TEST_F(ImportTachometer, ASampledTachometerIsTheWheelsEncoder) {
  const ImportReport report = import(with_tachometer(1500, turning), "tacho=front_left", "record");
  ASSERT_EQ(report.tachometers.size(), 1U);
  EXPECT_EQ(report.tachometers[0].pulses, 69);  // 23 turns a second for 3 s, half a turn behind the first
  EXPECT_EQ(report.tachometers[0].threshold, 1.5);
  EXPECT_NEAR(report.tachometers[0].stamp_sigma_s, 1.0 / kRate_hz / std::sqrt(12.0), 1e-6);
  EXPECT_TRUE(report.has_pulses);
  EXPECT_EQ(report.nodes[0].edges, 0);
  EXPECT_EQ(report.nodes[1].edges, 69);
  std::vector<Edge> edges;
  for (const auto& block : blocks_of_record())
    if (block.kind == BlockKind::kEdge)
      for (const Edge& edge : decode_edge(block).unpack()) edges.push_back(edge);
  ASSERT_EQ(edges.size(), 69U);
  for (std::size_t n = 0; n < edges.size(); ++n)
    EXPECT_NEAR(1e-9 * static_cast<double>(to_ns(edges[n].time)),
                uniform(0) + (static_cast<double>(n) + 0.5) / 23.0, 0.5001 / kRate_hz);

  // Each pulse is the zero mark: the angle is 0 at each, from the first to the last.
  RecordedAngle angle({.pulses_per_turn = 1}, edges);
  for (int turn = 1; turn < 68; ++turn) {
    std::array<double, 1> at{};
    const double time_s = uniform(0) + (turn + 0.75) / 23.0;
    ASSERT_TRUE(angle.angles(node_time_from_ns(std::llround(1e9 * time_s)), 0.0, at)) << turn;
    // Stamps are off by 0.5 / 500 s at the most, 0.023 of a turn, their mean by less.
    EXPECT_NEAR(std::remainder(at[0] / (2.0 * std::numbers::pi) - 0.25, 1.0), 0.0, 0.023) << turn;
  }
}

TEST_F(ImportTachometer, TheSameInputGivesTheSameRecordAndAnotherColumnAnother) {
  std::string text = with_tachometer(600, turning);
  import(text, "tacho=front_left", "one");
  import(text, "tacho=front_left", "two");
  import_samples({.samples = write("s.csv", samples(600, uniform)), .folder = folder_ / "three"}, vehicle());
  const auto epoch = [&](const char* folder) {
    RecordReader reader(folder_ / folder);
    while (const auto event = reader.next()) {
      SealedBlock block;
      if (accept(event->data, block) == Refusal::kNone && block.header.sequence > 0)
        return block.header.epoch;
    }
    return std::int64_t{-1};
  };
  EXPECT_EQ(epoch("one"), epoch("two"));
  EXPECT_NE(epoch("one"), epoch("three"));
}

TEST_F(ImportTachometer, RefusesWhatIsNoTachometerByName) {
  const std::string text = with_tachometer(600, turning);
  EXPECT_NE(refusal(text, "tach=front_left").find("no column tach for --tachometer"), std::string::npos);
  EXPECT_NE(refusal(text, "tacho=rear_left").find("wheel rear_left: no node reads its encoder"),
            std::string::npos);
  EXPECT_NE(refusal(with_tachometer(600, [](std::size_t) { return 1.0; }), "tacho=front_left")
                .find("column tacho never changes"),
            std::string::npos);
}

}  // namespace
}  // namespace roadbalance

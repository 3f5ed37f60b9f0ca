#include "common/angle/pitch_pattern.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace roadbalance {
namespace {

constexpr int kTeeth = 96;
constexpr double kPitch_ns = 580'000.0;

/// Error of a tooth in pitches.
using ToothErrors = std::function<double(std::int64_t)>;

/// Turns of a ring at nearly constant speed; the first pulse is called `number`, and truly is tooth `tooth`.
ToothHistory turns(const ToothErrors& errors, std::int64_t number, std::int64_t tooth, double count,
                   double jitter_ns, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto pulses = static_cast<std::size_t>(count * kTeeth);
  ToothHistory history(pulses);
  for (std::size_t i = 0; i < pulses; ++i) {
    const auto n = static_cast<std::int64_t>(i);
    const double x = static_cast<double>(n) + errors((tooth + n) % kTeeth);
    const double time_ns = kPitch_ns * (x - 1e-6 * x * x) + jitter_ns * normal(random);
    history.push({std::llround(time_ns), number + n});
  }
  return history;
}

PitchTable learned(const ToothErrors& errors) {
  PitchTable table(kTeeth);
  for (int pass = 0; pass < 40; ++pass)
    table.learn(turns(errors, 0, 0, 6.0, 1000.0, static_cast<std::uint64_t>(100 + pass)), 0, 0);
  return table;
}

double uneven(std::int64_t tooth) {
  std::mt19937_64 random(static_cast<std::uint64_t>(tooth));
  return std::normal_distribution<double>(0.0, 0.08)(random);
}
/// Off centre: no tooth stands out.
double eccentric(std::int64_t tooth) {
  return 0.13 * std::sin(2.0 * std::numbers::pi * static_cast<double>(tooth) / kTeeth);
}
/// The same after every third of a turn.
double repeated(std::int64_t tooth) {
  return uneven(tooth % (kTeeth / 3));
}

TEST(PitchPattern, FindsTheToothWhereTheRingIsUneven) {
  const PitchTable table = learned(uneven);
  PitchPattern pattern(kTeeth);
  for (const std::int64_t tooth : {0, 1, 17, 50, 95}) {
    const auto history = turns(uneven, 1000, tooth, 2.0, 10'000.0);
    const auto origin = pattern.find_origin(history, table);
    ASSERT_TRUE(origin) << tooth;
    EXPECT_EQ((1000 + kTeeth - tooth - *origin) % kTeeth, 0) << tooth;
    EXPECT_GT(*origin, history.latest().number - kTeeth);
    EXPECT_LE(*origin, history.latest().number);
  }
}

TEST(PitchPattern, RefusesWhereNothingIsDistinctive) {
  PitchPattern pattern(kTeeth);
  for (const ToothErrors& errors :
       {ToothErrors([](std::int64_t) { return 0.0; }), ToothErrors(eccentric), ToothErrors(repeated)})
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
      EXPECT_FALSE(pattern.find_origin(turns(errors, 7, 30, 3.0, 10'000.0, seed), learned(errors)));
}

TEST(PitchPattern, RefusesAnotherRingTooMuchNoiseAndTooFewTeeth) {
  const PitchTable table = learned(uneven);
  PitchPattern pattern(kTeeth);
  const ToothErrors another = [](std::int64_t tooth) { return uneven(tooth + 1000); };
  EXPECT_FALSE(pattern.find_origin(turns(another, 7, 30, 3.0, 10'000.0), table));
  EXPECT_FALSE(pattern.find_origin(turns(uneven, 7, 30, 3.0, 300'000.0), table));
  EXPECT_FALSE(pattern.find_origin(turns(uneven, 7, 30, 0.8, 10'000.0), table));
  EXPECT_FALSE(pattern.find_origin(ToothHistory(8), table));
}

}  // namespace
}  // namespace roadbalance

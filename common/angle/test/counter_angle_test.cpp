#include "common/angle/counter_angle.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

#include "common/angle/counter_unwrap.hpp"

namespace roadbalance {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kTeeth = 96.0;
constexpr double kFirstMark_turns = 0.3;

/// Turns of the wheel: 12 to 18 a second within 20 s and back, in closed form.
double turns_at(double t) {
  const double w = kTurn / 40.0;
  return 15.0 * t - 3.0 / w * std::sin(w * t);
}
/// Instant at which the wheel has turned that far.
double instant_of(double turns) {
  double t = turns / 15.0;
  for (int k = 0; k < 40; ++k) t -= (turns_at(t) - turns) / 15.0;
  return t;
}
std::int64_t ns(double s) {
  return std::llround(1e9 * s);
}

struct Bus {
  double rate_hz = 50.0;
  CounterLatency latency{.mean_s = 0.008, .mean_sigma_s = 0.0, .jitter_s = 0.0005};
  double true_latency_s = 0.008;
};

/// A drive of `seconds` on which every message, mark and sample comes as it would; errors in rad over sigma.
struct Result {
  std::vector<double> error_rad, over_sigma;
  std::int64_t refused = 0;
  double scatter_pulses = 0.0;
  double rms() const {
    double sum = 0.0;
    for (const double e : error_rad) sum += e * e / static_cast<double>(error_rad.size());
    return std::sqrt(sum);
  }
};
Result drive(const Bus& bus, std::int64_t teeth_assumed = 96, double seconds = 60.0,
             double judged_from = 5.0) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, bus.latency.jitter_s);
  CounterUnwrap unwrap({.jitter_s = 0.005});
  CounterTrack track(bus.latency, 1);
  CounterAngle angle(teeth_assumed);
  Result result;
  double next_mark = 1.0 + kFirstMark_turns;
  const int messages = static_cast<int>(seconds * bus.rate_hz);
  for (int n = 0; n < messages; ++n) {
    const double sent = n / bus.rate_hz;
    if (n % 40 == 7) continue;  // lost
    const double sampled = sent - bus.true_latency_s + noise(random);
    const auto count = static_cast<std::int64_t>(std::floor(kTeeth * turns_at(sampled + 1.0)));
    if (unwrap.take(ns(sent), count % 1024) == CounterUnwrap::Outcome::kInvalid) continue;
    track.add(ns(sent), unwrap.count(), unwrap.run());
    const double asked =
        sent - 6.3 / bus.rate_hz - bus.true_latency_s;  // between messages, none on either side missing
    for (; instant_of(next_mark) - 1.0 < asked; next_mark += 1.0)
      (void)angle.mark(ns(instant_of(next_mark) - 1.0), track);
    if (asked < judged_from) continue;
    const auto found = angle.at(ns(asked), track);
    if (!found) {
      ++result.refused;
      continue;
    }
    const double truth = kTurn * (turns_at(asked + 1.0) - kFirstMark_turns);
    result.error_rad.push_back(std::remainder(found->angle_rad - truth, kTurn));
    result.over_sigma.push_back(std::abs(result.error_rad.back()) / found->sigma_rad);
  }
  EXPECT_EQ(unwrap.run(), 1);
  result.scatter_pulses = angle.scatter_pulses();
  return result;
}

void expect_honest(const Result& result, double most_deg) {
  ASSERT_GT(result.error_rad.size(), 500U);
  EXPECT_EQ(result.refused, 0);
  int within = 0;
  for (const double ratio : result.over_sigma) within += ratio < 2.0;
  const double share = within / static_cast<double>(result.over_sigma.size());
  std::printf("rms %.3f deg, %.1f %% within two sigma\n", result.rms() * 180.0 / std::numbers::pi,
              100.0 * share);
  EXPECT_GT(share, 0.90);
  EXPECT_LT(result.rms() * 180.0 / std::numbers::pi, most_deg);
}

TEST(CounterAngle, IsWithinItsUncertaintyBetweenMessages) {
  // One message: 1/sqrt(12) of a pulse and 0.5 ms of 18 turns a second are 1.1 and 3.2 degrees; the middle of
  // a quadratic through nine has half of that.
  expect_honest(drive({}), 1.9);
  expect_honest(drive({.rate_hz = 100.0}), 1.9);
  // At 20 Hz the quadratic must follow the speed over 0.4 s.
  expect_honest(drive({.rate_hz = 20.0}), 1.9);
  // Without jitter rounding is all there is.
  expect_honest(drive({.latency = {.mean_s = 0.008}}), 0.7);
}

TEST(CounterAngle, CarriesAWrongLatencyOnlyAsFarAsTheSpeedHasChanged) {
  // 2 ms more than we think: 13 degrees at 18 turns a second, but the marks were seen the same way.  The
  // difference of the speed to the marks' mean is left.
  const Bus bus{.latency = {.mean_s = 0.008, .mean_sigma_s = 0.002, .jitter_s = 0.0005},
                .true_latency_s = 0.010};
  expect_honest(drive(bus), 2.5);
}

TEST(CounterAngle, IsNotGivenWithoutAZeroMarkOrOutsideOfTheMessages) {
  CounterTrack track({}, 1);
  CounterAngle angle(96);
  for (int n = 0; n < 20; ++n) track.add(n * 20'000'000, 30 * n, 1);
  ASSERT_TRUE(track.at(205'000'000));
  // A steady counter: 30 counts in 20 ms, half a count above what it shows.
  EXPECT_NEAR(track.at(205'000'000)->pulses, 308.0, 1e-6);
  EXPECT_NEAR(track.at(205'000'000)->rate_hz, 1500.0, 1e-3);
  EXPECT_FALSE(angle.at(205'000'000, track)) << "an angle turned through is no angle";
  EXPECT_FALSE(track.at(-1));
  EXPECT_FALSE(track.at(19 * 20'000'000 + 1)) << "nothing is extrapolated";
  ASSERT_TRUE(angle.mark(205'000'000, track));
  EXPECT_NEAR(angle.at(205'000'000 + 32'000'000, track)->angle_rad, kTurn / 2.0, 1e-6);
  for (int n = 20; n < 40; ++n) track.add(n * 20'000'000, 30 * n, 2);  // counts were lost
  EXPECT_FALSE(angle.at(30 * 20'000'000, track)) << "the mark was seen in another run";
}

TEST(CounterAngle, IsRefusedWhereTheMarksContradictTheNumberOfPulses) {
  const Result result = drive({}, 95);
  EXPECT_TRUE(result.error_rad.empty()) << result.error_rad.size();
  EXPECT_GT(result.refused, 500);
  EXPECT_GT(result.scatter_pulses, CounterAngle::kWidestMark_pulses);
}

/// A steady counter of 1500 pulses a second, 30 every 20 ms, of a ring of 96: marks every 64 ms.
class SteadyCounter {
 public:
  static constexpr std::int64_t kTurn_ns = 64'000'000;
  /// The next mark, so many pulses off its place.
  bool mark(double off_pulses) {
    next_ns_ += kTurn_ns;
    const std::int64_t mark_ns = next_ns_ + std::llround(off_pulses / 1500.0 * 1e9);
    for (; message_ * 20'000'000 < mark_ns + 100'000'000; ++message_)
      track_.add(message_ * 20'000'000, 30 * message_, 1);
    return angle.mark(mark_ns, track_);
  }
  /// One more in the same turn, so many pulses behind the first one's place.
  bool second_mark(double behind_pulses) {
    next_ns_ -= kTurn_ns;
    return mark(behind_pulses);
  }
  /// At the instant of the last mark's place.
  std::optional<double> angle_deg() const {
    const auto found = angle.at(next_ns_, track_);
    if (!found) return std::nullopt;
    return std::remainder(found->angle_rad, kTurn) * 180.0 / std::numbers::pi;
  }
  CounterAngle angle{96};

 private:
  CounterTrack track_{{}, 1};
  std::int64_t message_ = 0, next_ns_ = 200'000'000;
};

TEST(CounterAngle, DoubtsItselfAfterAMarkElsewhereAndIsNotGivenAfterTwo) {
  SteadyCounter counter;
  for (int k = 0; k < CounterAngle::kSettled; ++k) ASSERT_TRUE(counter.mark(0.0));
  EXPECT_FALSE(counter.angle.is_uncertain());
  EXPECT_FALSE(counter.mark(5.0));
  EXPECT_TRUE(counter.angle.is_uncertain());
  ASSERT_TRUE(counter.angle_deg());
  EXPECT_NEAR(*counter.angle_deg(), 0.0, 1e-6);
  EXPECT_FALSE(counter.mark(-7.0));
  EXPECT_FALSE(counter.angle_deg());
  EXPECT_TRUE(counter.mark(0.0)) << "they were false";
  EXPECT_FALSE(counter.angle.is_uncertain());
  EXPECT_NEAR(*counter.angle_deg(), 0.0, 1e-6);
  EXPECT_EQ(counter.angle.elsewhere(), 2);
  EXPECT_EQ(counter.angle.moved(), 0);
}

TEST(CounterAngle, TakesThePlaceThatAsManyMarksAgreeOnAndSaysThatItMoved) {
  SteadyCounter counter;
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(counter.mark(0.0));
  for (int k = 1; k < CounterAngle::kSettled; ++k) {
    EXPECT_FALSE(counter.mark(5.0));
    EXPECT_EQ(counter.angle_deg().has_value(), k == 1);
  }
  EXPECT_FALSE(counter.mark(5.0));
  EXPECT_EQ(counter.angle.moved(), 1);
  EXPECT_FALSE(counter.angle.is_uncertain());
  EXPECT_EQ(counter.angle.marks(), CounterAngle::kSettled);
  EXPECT_NEAR(*counter.angle_deg(), -5.0 * 360.0 / 96.0, 1e-3);
  EXPECT_TRUE(counter.mark(5.0));
}

TEST(CounterAngle, TakesNoPlaceThatMarksElsewhereDoNotAgreeOn) {
  SteadyCounter counter;
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(counter.mark(0.0));
  for (int k = 0; k < 40; ++k) EXPECT_FALSE(counter.mark(k % 2 == 0 ? 8.0 : -20.0));
  EXPECT_EQ(counter.angle.moved(), 0);
  EXPECT_FALSE(counter.angle_deg());
  EXPECT_TRUE(counter.mark(0.0));
  EXPECT_NEAR(*counter.angle_deg(), 0.0, 1e-6);
}

TEST(CounterAngle, FollowsASmallLossWithinItsMemory) {
  SteadyCounter counter;
  for (int k = 0; k < 2000; ++k) ASSERT_TRUE(counter.mark(0.0));
  for (int k = 0; k < CounterAngle::kMemory; ++k)
    ASSERT_TRUE(counter.mark(1.0)) << "too little to be elsewhere";
  // 1/e of the older ones is left; in a mean over all 2000 it would be 0.89.
  EXPECT_NEAR(*counter.angle_deg(), -(1.0 - std::exp(-1.0)) * 360.0 / 96.0, 0.02 * 3.75);
}

TEST(CounterAngle, IsNotGivenWhereTwoMarksLieOnTheWheelHoweverNear) {
  // 96 pulses a turn; a magnet and a bolt head, 15 degrees apart to half a turn.
  for (const double apart : {4.0, 8.0, 16.0, 33.0, 48.0}) {
    SteadyCounter counter;
    for (int turn = 0; turn < 50; ++turn) {
      (void)counter.mark(0.0);
      (void)counter.second_mark(apart);
      EXPECT_TRUE(turn == 0 || !counter.angle_deg()) << apart << " at turn " << turn;
    }
    const std::array<int, 2> counts = counter.angle.mark_counts();
    const int near = static_cast<int>(std::lround(apart)), far = 96 - near;
    EXPECT_TRUE((counts == std::array{near, far}) || (counts == std::array{far, near}) ||
                (near == far && counts == std::array{48, 0}))
        << apart << ": " << counts[0] << ", " << counts[1];
  }
}

TEST(CounterAngle, StandsAFalseMarkInFiveTurns) {
  SteadyCounter counter;
  for (int turn = 0; turn < 100; ++turn) {
    (void)counter.mark(0.0);
    if (turn > 20) {
      ASSERT_TRUE(counter.angle_deg()) << turn;
      EXPECT_NEAR(*counter.angle_deg(), 0.0, 1e-6);
      EXPECT_EQ(counter.angle.mark_counts(), (std::array{0, 0}));
    }
    if (turn > 20 && turn % 5 == 0) (void)counter.second_mark(11.0 + turn % 37);
  }
}

TEST(CounterAngle, RefusesWhatCannotBe) {
  EXPECT_THROW(CounterAngle(0), std::invalid_argument);
  EXPECT_THROW(CounterTrack({.jitter_s = -1.0}, 1), std::invalid_argument);
  EXPECT_THROW(CounterTrack({}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance

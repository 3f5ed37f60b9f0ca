#include "common/dsp/clipping_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "common/dsp/linear_filter.hpp"
#include "common/test/no_allocation.hpp"

namespace roadbalance {
namespace {

constexpr double kRate_hz = 2000.0, kPi = std::numbers::pi;
constexpr double kFine = 50.0 / (1 << 23);  ///< m/s^2 a count: 24 bits of 50 m/s^2
constexpr double kCoarse = 50.0 / (1 << 9);

using Signal = std::function<double()>;  ///< m/s^2, sample by sample
using Made = std::function<Signal(unsigned seed)>;

/// The anti-aliasing filter of the demonstration car.
class LowPass {
 public:
  LowPass(double cutoff_hz, double rate_hz)
      : filter_(discretise_ramp_invariant(butterworth(6, cutoff_hz), 1.0 / rate_hz)),
        state_(Eigen::VectorXd::Zero(6)) {}
  double operator()(double value) {
    state_ = (filter_.A * state_ + filter_.b0 * last_ + filter_.b1 * value).eval();
    last_ = value;
    return state_(0);
  }

 private:
  DiscreteFilter filter_;
  Eigen::VectorXd state_;
  double last_ = 0.0;
};

struct Road {
  double potholes_1_s = 0.0;     ///< 6 to 52 mm deep, 20 ms long; a carrier sees 25 to 220 m/s^2
  double joint_m = 0.0;          ///< of one height, every 0.3 s
  double clipped_at = INFINITY;  ///< before the filter, m/s^2
  double tone_m_s2 = 0.0;        ///< at 16.3 Hz, beside what the road does
};

/// Acceleration of the carrier of a quarter car on a road whose velocity is white, in steps of half a sample.
/// With no pothole its rms is 6.6 m/s^2 and its peak of four minutes 28 m/s^2.
class Carrier {
 public:
  Carrier(const Road& road, unsigned seed) : road_(road), random_(seed), filter_(200.0, 2.0 * kRate_hz) {}

  double operator()() {
    double sample = 0.0;
    for (int half = 0; half < 2; ++half)
      sample = filter_(std::clamp(step(0.5 / kRate_hz), -road_.clipped_at, road_.clipped_at));
    return sample;
  }

 private:
  double step(double h) {
    time_s_ += h;
    height_m_ += 0.01 * std::sqrt(h) * normal_(random_) - 0.5 * h * height_m_;
    if (left_s_ <= 0.0 && uniform_(random_) < road_.potholes_1_s * h) {
      left_s_ = kBump_s;
      bump_m_ = -0.006 - 0.046 * uniform_(random_);
    }
    if (road_.joint_m > 0.0 && std::fmod(time_s_, 0.3) < h) {
      left_s_ = kBump_s;
      bump_m_ = road_.joint_m;
    }
    left_s_ -= h;
    const double bump = left_s_ > 0.0 ? 0.5 * bump_m_ * (1.0 - std::cos(2.0 * kPi * left_s_ / kBump_s)) : 0.0;
    const double strut_n = 22'000.0 * (body_m_ - wheel_m_) + 1'500.0 * (body_m_s_ - wheel_m_s_);
    const double up = (strut_n + 215'000.0 * (height_m_ + bump - wheel_m_)) / 34.0;
    body_m_s_ -= h * strut_n / 350.0;
    body_m_ += h * body_m_s_;
    wheel_m_s_ += h * up;
    wheel_m_ += h * wheel_m_s_;
    return up + road_.tone_m_s2 * std::cos(2.0 * kPi * 16.3 * time_s_);
  }

  static constexpr double kBump_s = 0.02;
  Road road_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_;
  LowPass filter_;
  double time_s_ = 0.0, height_m_ = 0.0, left_s_ = 0.0, bump_m_ = 0.0;
  double body_m_ = 0.0, body_m_s_ = 0.0, wheel_m_ = 0.0, wheel_m_s_ = 0.0;
};

Made carrier(const Road& road) {
  return [road](unsigned seed) { return [car = std::make_shared<Carrier>(road, seed)] { return (*car)(); }; };
}

/// Cut off behind the filter.
Made cut(const Made& made, double low, double high) {
  return [=](unsigned seed) {
    return [signal = made(seed), low, high] { return std::clamp(signal(), low, high); };
  };
}

/// White, of variance 1, then low-passed.
Made noise(double cutoff_hz, double gain) {
  return [=](unsigned seed) -> Signal {
    const auto random = std::make_shared<std::mt19937_64>(seed);
    const auto filter = std::make_shared<LowPass>(cutoff_hz, kRate_hz);
    return [=, normal = std::normal_distribution<double>()]() mutable {
      return gain * (*filter)(normal(*random));
    };
  };
}

Made function_of_time(const std::function<double(double time_s, unsigned seed)>& value) {
  return
      [=](unsigned seed) -> Signal { return [=, k = 0]() mutable { return value(k++ / kRate_hz, seed); }; };
}

struct Tried {
  int found = 0;
  double latest_s = 0.0;              ///< of those found
  double least = INFINITY, most = 0;  ///< limits, m/s^2
};
Tried listen(const Made& made, int drives, double seconds, double m_s2_per_count = kFine) {
  Tried tried;
  for (int drive = 0; drive < drives; ++drive) {
    const Signal signal = made(static_cast<unsigned>(drive) + 1);
    ClippingDetector detector(kRate_hz);
    double first_s = -1.0;
    for (double t = 0.0; t < seconds; t += 1.0 / kRate_hz) {
      detector.add(static_cast<std::int32_t>(std::lround(signal() / m_s2_per_count)));
      if (first_s < 0.0 && detector.limits().any()) first_s = t;
    }
    if (first_s < 0.0) continue;
    ++tried.found;
    tried.latest_s = std::max(tried.latest_s, first_s);
    const auto& [low, high, rest] = detector.limits();
    for (const auto& limit : {low, high}) {
      if (!limit) continue;
      tried.least = std::min(tried.least, std::abs(*limit) * m_s2_per_count);
      tried.most = std::max(tried.most, std::abs(*limit) * m_s2_per_count);
    }
  }
  return tried;
}

// No false alarm in eight drives of two minutes of each kind, and there are twelve: with 95 % fewer than one
// an hour.

TEST(ClippingDetector, TakesNoGaussianNoiseForClipped) {
  for (const double cutoff_hz : {10.0, 50.0, 200.0, 900.0})
    EXPECT_EQ(listen(noise(cutoff_hz, 3.0), 8, 120.0).found, 0) << cutoff_hz;
  EXPECT_EQ(listen(carrier({}), 8, 120.0).found, 0);
}

TEST(ClippingDetector, TakesNoShocksForClippedHoweverHeavyTheTail) {
  for (const double potholes_1_s : {0.03, 0.1, 0.3, 1.0, 3.0})
    EXPECT_EQ(listen(carrier({.potholes_1_s = potholes_1_s}), 8, 120.0, 10 * kFine).found, 0) << potholes_1_s;
  // Of one height each: all their tops are alike, and round.
  for (const double joint_m : {0.003, 0.01, 0.03})
    EXPECT_EQ(listen(carrier({.joint_m = joint_m}), 8, 120.0, 10 * kFine).found, 0) << joint_m;
}

TEST(ClippingDetector, TakesNoQuietOrCoarseChannelForClipped) {
  for (const double counts : {0.3, 1.0, 3.0, 10.0})
    EXPECT_EQ(listen(noise(900.0, counts), 3, 120.0, 1.0).found, 0) << counts;
  EXPECT_EQ(listen([](unsigned) { return [] { return 3.0; }; }, 1, 10.0).found, 0) << "at rest";
  for (const int bits : {12, 10, 8, 6})
    EXPECT_EQ(listen(carrier({}), 4, 120.0, 50.0 / (1 << (bits - 1))).found, 0) << bits;
}

TEST(ClippingDetector, TakesNoToneForClippedThoughItsTopsAreAllAlike) {
  const auto hz = [](unsigned seed) { return 5.0 + 3.7 * seed; };
  EXPECT_EQ(
      listen(function_of_time([&](double t, unsigned seed) { return std::cos(2 * kPi * hz(seed) * t); }), 20,
             60.0)
          .found,
      0);
  EXPECT_EQ(listen(function_of_time([&](double t, unsigned seed) {
                     return std::cos(2 * kPi * t * kRate_hz / (10 + 3 * seed));
                   }),
                   20, 60.0)
                .found,
            0)
      << "a whole number of samples in a turn";
  EXPECT_EQ(listen(function_of_time([&](double t, unsigned seed) {
                     return std::min(1.0, t / 40.0) * std::cos(2 * kPi * hz(seed) * t);
                   }),
                   20, 120.0)
                .found,
            0)
      << "run up and held";
  EXPECT_EQ(listen(function_of_time([&](double t, unsigned seed) {
                     return std::cos(2 * kPi * hz(seed) * t) +
                            0.1 * seed * std::cos(2 * kPi * (hz(seed) + 0.3) * t);
                   }),
                   20, 60.0)
                .found,
            0)
      << "two wheels that beat";
  EXPECT_EQ(listen(function_of_time([&](double t, unsigned seed) {
                     return std::cos(2 * kPi * hz(seed) * t) - std::cos(6 * kPi * hz(seed) * t) / 9;
                   }),
                   20, 60.0)
                .found,
            0)
      << "no curvature at its top";
  for (const double tone_m_s2 : {10.0, 30.0, 100.0})
    EXPECT_EQ(listen(carrier({.tone_m_s2 = tone_m_s2}), 10, 60.0, 10 * kFine).found, 0) << tone_m_s2;
}

// A carrier's peak is 28 m/s^2.  Half of it is reached 1.3 times a second on each side, and 24 tops are
// wanted.

TEST(ClippingDetector, FindsTheLimitOfAConverter) {
  for (const double limit : {5.7, 8.5, 14.2})
    for (const double step : {kFine, kCoarse}) {
      const Tried tried = listen(cut(carrier({}), -limit, limit), 10, 30.0, step);
      EXPECT_EQ(tried.found, 10) << limit;
      EXPECT_NEAR(tried.least, limit, 0.05 * limit + step);
      EXPECT_NEAR(tried.most, limit, 0.05 * limit + step);
    }
}

TEST(ClippingDetector, FindsTheLimitBehindWhichAFilterRoundsTheTops) {
  for (const double limit : {8.5, 11.4, 14.2}) {
    const Tried tried = listen(carrier({.clipped_at = limit}), 20, 60.0);
    EXPECT_EQ(tried.found, 20) << limit;
    EXPECT_LT(tried.latest_s, 30.0) << "24 tops take 20 s on either side, and one of the two is enough";
    EXPECT_NEAR(tried.least, limit, 0.07 * limit) << "the overshoot of a step is 14 %, of slower tops less";
    EXPECT_NEAR(tried.most, limit, 0.07 * limit);
  }
}

TEST(ClippingDetector, FindsTheLimitOfOneSideInNoise) {
  const auto one_sided = [](unsigned seed) -> Signal {
    return
        [car = carrier({})(seed), hiss = noise(900.0, 0.05)(seed)] { return std::min(car(), 11.4) + hiss(); };
  };
  const Tried tried = listen(one_sided, 10, 30.0);
  EXPECT_EQ(tried.found, 10);
  EXPECT_NEAR(tried.least, 11.4, 0.5);
  EXPECT_NEAR(tried.most, 11.4, 0.5) << "nothing is known of the other side";
}

TEST(ClippingDetector, FindsALimitThatOnlyPotholesReach) {
  const Tried tried = listen(carrier({.potholes_1_s = 0.3, .clipped_at = 40.0}), 10, 120.0);
  EXPECT_EQ(tried.found, 10);
  EXPECT_NEAR(tried.least, 40.0, 3.0);
}

TEST(ClippingDetector, TellsWhichSamplesAreAtTheLimit) {
  ClippingDetector detector(kRate_hz);
  const Signal signal = cut(carrier({}), -1e9, 10.0)(1);
  for (int k = 0; k < 30 * kRate_hz; ++k) detector.add(static_cast<std::int32_t>(signal() / kFine));
  ASSERT_TRUE(detector.limits().high);
  EXPECT_FALSE(detector.limits().low);
  const auto at = [&](double m_s2) {
    return detector.limits().reached_by(static_cast<std::int32_t>(m_s2 / kFine));
  };
  EXPECT_TRUE(at(10.0));
  EXPECT_FALSE(at(9.0));
  EXPECT_FALSE(at(-20.0));
}

TEST(ClippingDetector, ForgetsALimitThatIsPassedAndAllAtARestart) {
  ClippingDetector detector(kRate_hz);
  Signal signal = cut(carrier({}), -10.0, 10.0)(1);
  const auto drive = [&](double seconds) {
    for (int k = 0; k < seconds * kRate_hz; ++k) detector.add(static_cast<std::int32_t>(signal() / kFine));
  };
  drive(30.0);
  EXPECT_TRUE(detector.limits().any());
  detector.skip();
  EXPECT_TRUE(detector.limits().any()) << "a hole changes no sensor";
  signal = carrier({})(2);
  drive(60.0);
  EXPECT_FALSE(detector.limits().any()) << "30 % of the time at the limit or beyond is now beyond";
  signal = cut(carrier({}), -10.0, 10.0)(1);
  detector.restart();
  EXPECT_FALSE(detector.limits().any());
  drive(30.0);
  EXPECT_TRUE(detector.limits().any()) << "as if it had never heard the other";
}

TEST(ClippingDetector, NeverAllocatesAndGivesAVerdictEachSecond) {
  ClippingDetector detector(kRate_hz);
  const Signal signal = cut(carrier({}), -10.0, 10.0)(1);
  std::vector<std::int32_t> counts(20'000);
  std::ranges::generate(counts, [&] { return static_cast<std::int32_t>(signal() / kFine); });
  int verdicts = 0;
  {
    const test::NoAllocation guard;
    for (const std::int32_t count : counts) verdicts += detector.add(count);
  }
  EXPECT_EQ(verdicts, 10);
  EXPECT_TRUE(detector.limits().any());
}

TEST(ClippingDetector, RefusesARateThatIsNone) {
  EXPECT_THROW(ClippingDetector(0.0), std::invalid_argument);
  EXPECT_THROW(ClippingDetector(NAN), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance

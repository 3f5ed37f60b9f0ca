#pragma once

#include <cmath>
#include <cstdint>

namespace roadbalance::sim {

/// The use of a sequence of random numbers.  Sequences of different use are independent.
enum class Use : std::uint64_t {
  kParameters = 1,
  kRollingRadius,
  kInitialAngle,
  kWander,
  kRoad,
  kSensorNoise,
  kPitchError,
  kStampJitter,
  kTestSample,  ///< hil_tests/deterministic/hashed_sample.hpp
  kTestFault,
  kCounterAge,
  kScenario,  ///< values of its keys
  kRoadStretch,
  kObstacle,
  kRadialForce,
  kSensorFault,
  kMountingNoise,
  kFilterFault,
};

/// Random numbers that are a pure function of (seed, use, which, counter): no state, so every process
/// draws the same car and a restarted one meets the same road.
///
/// Source: the finaliser of SplitMix64, G. Steele et al., Fast splittable pseudorandom number generators,
/// OOPSLA 2014, run over a counter.
class RandomSequence {
 public:
  RandomSequence(std::uint64_t seed, Use use, std::uint64_t which)
      : key_(mix(mix(mix(seed) ^ static_cast<std::uint64_t>(use)) ^ which)) {}

  std::uint64_t bits(std::int64_t counter) const {
    return mix(key_ + static_cast<std::uint64_t>(counter) * 0x9E3779B97F4A7C15ULL);
  }

  /// Uniform in [0, 1).
  double uniform(std::int64_t counter) const { return static_cast<double>(bits(counter) >> 11) * 0x1p-53; }

  /// Uniform in [low, high).
  double between(std::int64_t counter, double low, double high) const {
    return low + (high - low) * uniform(counter);
  }

  /// Mean 0, variance 1, nearly normal: the sum of four 16-bit uniforms (excess kurtosis -0.3, never beyond
  /// +-3.4642).  Whatever a filter averages over many of them is normal; and it costs a few nanoseconds.
  double normal(std::int64_t counter) const {
    const std::uint64_t b = bits(counter);
    const std::int64_t sum =
        static_cast<std::int64_t>((b & 0xFFFF) + ((b >> 16) & 0xFFFF) + ((b >> 32) & 0xFFFF) + (b >> 48));
    return (static_cast<double>(sum) - 2.0 * 65535.0) * kNormalScale;
  }

 private:
  /// 1 / sqrt(4 (2^32 - 1) / 12), the variance of four uniforms on 0 .. 65535.
  static constexpr double kNormalScale = 1.0 / 37837.22723720648;

  static std::uint64_t mix(std::uint64_t x) {
    x ^= x >> 30;
    x *= 0xBF58476D1CE4E5B9ULL;
    x ^= x >> 27;
    x *= 0x94D049BB133111EBULL;
    return x ^ (x >> 31);
  }

  std::uint64_t key_;
};

}  // namespace roadbalance::sim

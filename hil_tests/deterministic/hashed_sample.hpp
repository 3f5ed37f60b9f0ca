#pragma once

#include <cstdint>

#include "common/frontend/front_end.hpp"
#include "sim/random.hpp"

namespace roadbalance::test {

/// The samples of one acceleration channel in test mode: a hash of where each belongs, so that one lost,
/// swapped, doubled or altered shows without a reference copy.
///
/// With the finaliser of SplitMix64, all arithmetic modulo 2^64 and >> without sign,
///
///     mix(x):  x ^= x >> 30;  x *= 0xBF58476D1CE4E5B9;  x ^= x >> 27;  x *= 0x94D049BB133111EB;  x ^= x >>
///     31 key    = mix(mix(mix(epoch) ^ 9) ^ (16 node + channel))      channel 0 .. 11 sample = (mix(key +
///     index 0x9E3779B97F4A7C15) >> 40) - 2^23  index: of the scan in its epoch, from 0
///
/// tools/check_record.py computes the same on its own.
class HashedChannel {
 public:
  HashedChannel(std::int32_t node, std::int64_t epoch, int channel)
      : sequence_(static_cast<std::uint64_t>(epoch), sim::Use::kTestSample,
                  static_cast<std::uint64_t>(16 * node + channel)) {}

  std::int32_t at(std::int64_t index) const {
    return static_cast<std::int32_t>(sequence_.bits(index) >> 40) - kFullScaleCounts;
  }

 private:
  sim::RandomSequence sequence_;
};

}  // namespace roadbalance::test

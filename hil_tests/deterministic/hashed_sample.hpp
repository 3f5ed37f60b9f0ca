#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/types/scan.hpp"

namespace roadbalance::test {

/// The samples of a node epoch in test mode: a hash of where each belongs, so that one lost, swapped, doubled
/// or altered shows without a reference copy.
///
/// With the finaliser of SplitMix64, all arithmetic modulo 2^64 and >> without sign,
///
///     mix(x):  x ^= x >> 30;  x *= 0xBF58476D1CE4E5B9;  x ^= x >> 27;  x *= 0x94D049BB133111EB;
///              x ^= x >> 31
///     key    = mix(mix(mix(epoch) ^ 9) ^ (16 node + channel))      channel 0 .. 11
///     sample = (mix(key + index 0x9E3779B97F4A7C15) >> 40) - 2^23  index: of the scan in its epoch, from 0
///
/// That is sim::RandomSequence of Use::kTestSample, all channels at once: a fifth of a fault run's time went
/// there.  tools/check_record.py computes the same on its own.
class HashedScans {
 public:
  using Row = std::array<std::int32_t, kAccelerations>;

  HashedScans() = default;
  HashedScans(std::int32_t node, std::int64_t epoch);

  /// The samples of scan `index`.
  Row at(std::int64_t index) const;
  /// Samples of scans `first`, `first` + 1 ..., by the processor's wide multiplication where it has one.
  void fill(std::int64_t first, std::span<Row> rows) const;

 private:
  // Two registers of eight: of each channel, and of channels 8 to 11 once more for the next scan.
  static constexpr std::size_t kLanes = 16;
  alignas(64) std::array<std::uint64_t, kLanes> key_{};
};

}  // namespace roadbalance::test

#pragma once

#include <cstdint>

#include "sim/random.hpp"

namespace roadbalance::test {

/// The only source of chance in a run: everything drawn is a function of the run's seed and the stream.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream) : sequence_(seed, sim::Use::kTestFault, stream) {}

  std::uint64_t bits() { return sequence_.bits(counter_++); }
  /// In [0, 1).
  double uniform() { return sequence_.uniform(counter_++); }
  double between(double low, double high) { return low + (high - low) * uniform(); }
  bool chance(double probability) { return probability > 0 && uniform() < probability; }
  /// In 0 .. count - 1.
  std::int64_t below(std::int64_t count) {
    return static_cast<std::int64_t>(uniform() * static_cast<double>(count));
  }

 private:
  sim::RandomSequence sequence_;
  std::int64_t counter_ = 0;
};

}  // namespace roadbalance::test

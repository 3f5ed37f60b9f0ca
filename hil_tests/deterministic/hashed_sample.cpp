#include "hil_tests/deterministic/hashed_sample.hpp"

#include <cstring>

namespace roadbalance::test {
namespace {

constexpr std::uint64_t kUse = 9;  // sim::Use::kTestSample
constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15;

// Of a number, or of each in a vector.
#define RB_MIX(x)             \
  do {                        \
    x ^= x >> 30;             \
    x *= 0xBF58476D1CE4E5B9U; \
    x ^= x >> 27;             \
    x *= 0x94D049BB133111EBU; \
    x ^= x >> 31;             \
  } while (false)

std::uint64_t mix(std::uint64_t x) {
  RB_MIX(x);
  return x;
}

#if defined(__x86_64__)
bool has_wide_multiplication() {
  static const bool has_it = __builtin_cpu_supports("avx512dq") != 0;
  return has_it;
}

#define RB_WIDE_TARGET __attribute__((target("avx512f,avx512dq")))
using EightWords = std::uint64_t __attribute__((vector_size(64)));
using EightCounts = std::int32_t __attribute__((vector_size(32)));

RB_WIDE_TARGET inline EightCounts counts_of(EightWords x) {
  RB_MIX(x);
  x >>= 40;
  x -= std::uint64_t{kFullScaleCounts};
  return __builtin_convertvector(x, EightCounts);
}

// Eight channels, then the others.
RB_WIDE_TARGET void hash_wide(const std::uint64_t* key, std::uint64_t step,
                              std::span<HashedScans::Row> rows) {
  EightWords first, others;
  std::memcpy(&first, key, sizeof first);
  std::memcpy(&others, key + 8, sizeof others);
  for (HashedScans::Row& row : rows) {
    const EightCounts first_counts = counts_of(first + step);
    const EightCounts other_counts = counts_of(others + step);
    std::memcpy(row.data(), &first_counts, sizeof first_counts);
    std::memcpy(row.data() + 8, &other_counts, sizeof row - sizeof first_counts);
    step += kStep;
  }
}
#else
bool has_wide_multiplication() {
  return false;
}

void hash_wide(const std::uint64_t*, std::uint64_t, std::span<HashedScans::Row>) {}
#endif

}  // namespace

HashedScans::HashedScans(std::int32_t node, std::int64_t epoch) {
  const std::uint64_t of_epoch = mix(mix(static_cast<std::uint64_t>(epoch)) ^ kUse);
  for (int channel = 0; channel < kAccelerations; ++channel)
    key_[static_cast<std::size_t>(channel)] = mix(of_epoch ^ static_cast<std::uint64_t>(16 * node + channel));
}

void HashedScans::fill(std::int64_t first, std::span<Row> rows) const {
  if (has_wide_multiplication())
    return hash_wide(key_.data(), static_cast<std::uint64_t>(first) * kStep, rows);
  for (Row& row : rows) row = at(first++);
}

HashedScans::Row HashedScans::at(std::int64_t index) const {
  Row row;
  for (std::size_t channel = 0; channel < row.size(); ++channel) {
    const std::uint64_t bits = mix(key_[channel] + static_cast<std::uint64_t>(index) * kStep);
    row[channel] = static_cast<std::int32_t>(bits >> 40) - kFullScaleCounts;
  }
  return row;
}

}  // namespace roadbalance::test

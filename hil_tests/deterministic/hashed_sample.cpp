#include "hil_tests/deterministic/hashed_sample.hpp"

#include <cstring>

namespace roadbalance::test {
namespace {

constexpr std::uint64_t kUse = 9;  // sim::Use::kTestSample
constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15;

// Hash of a number, or of each in a vector.
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

// Two rows at a time: eight channels of each, then the four others of both.  Returns how many rows that are.
RB_WIDE_TARGET std::size_t hash_pairs(const std::uint64_t* key, std::uint64_t step,
                                      std::span<HashedScans::Row> rows) {
  EightWords first, others;
  std::memcpy(&first, key, sizeof first);
  std::memcpy(&others, key + 8, sizeof others);
  std::size_t k = 0;
  for (; k + 2 <= rows.size(); k += 2, step += 2 * kStep) {
    const EightCounts one = counts_of(first + step);
    const EightCounts two = counts_of(first + (step + kStep));
    const EightCounts both = counts_of(others + step);
    std::memcpy(rows[k].data(), &one, sizeof one);
    std::memcpy(rows[k].data() + 8, &both, sizeof both / 2);
    std::memcpy(rows[k + 1].data(), &two, sizeof two);
    std::memcpy(rows[k + 1].data() + 8, reinterpret_cast<const char*>(&both) + sizeof both / 2,
                sizeof both / 2);
  }
  return k;
}
#else
bool has_wide_multiplication() {
  return false;
}

std::size_t hash_pairs(const std::uint64_t*, std::uint64_t, std::span<HashedScans::Row>) {
  return 0;
}
#endif

}  // namespace

HashedScans::HashedScans(std::int32_t node, std::int64_t epoch) {
  const std::uint64_t of_epoch = mix(mix(static_cast<std::uint64_t>(epoch)) ^ kUse);
  for (int channel = 0; channel < kAccelerations; ++channel)
    key_[static_cast<std::size_t>(channel)] = mix(of_epoch ^ static_cast<std::uint64_t>(16 * node + channel));
  for (std::size_t lane = kAccelerations; lane < kLanes; ++lane) key_[lane] = key_[lane - 4] + kStep;
}

void HashedScans::fill(std::int64_t first, std::span<Row> rows) const {
  const std::uint64_t step = static_cast<std::uint64_t>(first) * kStep;
  std::size_t k = has_wide_multiplication() ? hash_pairs(key_.data(), step, rows) : 0;
  for (; k < rows.size(); ++k) rows[k] = at(first + static_cast<std::int64_t>(k));
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

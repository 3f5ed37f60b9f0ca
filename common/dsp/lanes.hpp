#pragma once

#include <cstdlib>
#include <cstring>

// Arithmetic across so many doubles at once, for kernels that are compiled once for each width and chosen by
// the processor at run time: the product runs on every x86-64 and is as fast as the machine allows.
//
// A kernel is an always_inline function template of the width; one function with RB_AVX512, one with RB_AVX2
// and one without call it with 8, 4 and 2.  It must not call inline functions of others (Eigen, std):
// a linker that keeps one of their copies might keep the one for the newest processor.

namespace roadbalance {

template <int kLanes>
struct Lanes;
template <>
struct Lanes<1> {
  using Vector = double;
};
template <>
struct Lanes<2> {
  typedef double Vector __attribute__((vector_size(16)));
};
template <>
struct Lanes<4> {
  typedef double Vector __attribute__((vector_size(32)));
};
template <>
struct Lanes<8> {
  typedef double Vector __attribute__((vector_size(64)));
};

#if defined(__x86_64__)
#define RB_AVX512 __attribute__((target("avx512f,fma")))
#define RB_AVX2 __attribute__((target("avx2,fma")))
#else
#define RB_AVX512
#define RB_AVX2
#endif

/// For tests: no more lanes than that many are used, 2 or 4, so that one machine tries what others run.
inline constexpr const char* kMostLanesVariable = "RB_MOST_LANES";

/// Lanes of this processor: 8, 4, or 2 where nothing is known of it; kMostLanesVariable at the most.
inline int widest_lanes() {
#if defined(__x86_64__)
  const char* const variable = std::getenv(kMostLanesVariable);
  const int most = variable != nullptr ? std::atoi(variable) : 8;
  if (most >= 8 && __builtin_cpu_supports("avx512f") != 0) return 8;
  if (most >= 4 && __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0) return 4;
#endif
  return 2;
}

/// The one of three functions that fits this processor.
template <typename Function>
Function* for_this_processor(Function* avx512, Function* avx2, Function* plain) {
  const int lanes = widest_lanes();
  return lanes == 8 ? avx512 : lanes == 4 ? avx2 : plain;
}

}  // namespace roadbalance

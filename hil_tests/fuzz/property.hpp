#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace roadbalance::fuzz {

/// Ends the run, so that the fuzzer keeps the input, unless the property holds.
inline void require(bool holds, const char* property) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", property);
  std::abort();
}

/// Counts how often the code behind the refusals was reached, and prints it at the end: tools/fuzz takes a
/// fuzzer that never got there for one that has proven nothing.
class Reached {
 public:
  explicit Reached(const char* what) : what_(what) {}
  Reached(const Reached&) = delete;
  Reached& operator=(const Reached&) = delete;
  ~Reached() { std::fprintf(stderr, "stat::reached %s: %lld\n", what_, static_cast<long long>(times_)); }
  void count() { ++times_; }

 private:
  const char* what_;
  std::int64_t times_ = 0;
};

}  // namespace roadbalance::fuzz

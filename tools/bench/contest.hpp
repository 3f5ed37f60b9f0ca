#pragma once

#include <ctime>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

namespace roadbalance::bench {

/// One of those that compete for a row: each does the same amount of work a call.
struct Contender {
  std::function<void()> work;
  std::vector<double> cpu_s{};  ///< of one call, one for each round
};

inline double cpu_now_s() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline double median(std::vector<double> of) {
  const auto middle = of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2);
  std::nth_element(of.begin(), middle, of.end());
  return *middle;
}

/// 15, or as many as tools/bench/run --quick asks for.
inline int rounds_of_contest() {
  const char* const asked = std::getenv("RB_BENCH_ROUNDS");
  return asked ? std::max(1, std::atoi(asked)) : 15;
}

/// Rounds in which each contender has its turn of about `turn_s`, so that what else the machine does meets
/// all alike.  CPU time of all of this program counts (LCM reads in a thread of its own), not the wall's.
inline void compete(std::vector<Contender>& contenders, int rounds = rounds_of_contest(),
                    double turn_s = 0.02) {
  std::vector<int> calls;
  for (Contender& one : contenders) {
    one.work();  // warm
    const double begin = cpu_now_s();
    one.work();
    calls.push_back(std::max(1, static_cast<int>(turn_s / std::max(1e-7, cpu_now_s() - begin))));
  }
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      const double begin = cpu_now_s();
      for (int call = 0; call < calls[i]; ++call) contenders[i].work();
      contenders[i].cpu_s.push_back((cpu_now_s() - begin) / calls[i]);
    }
}

/// Median over the rounds of what `ours` takes over what `peer` took in the same round.
inline double ratio(const Contender& ours, const Contender& peer) {
  std::vector<double> each(ours.cpu_s.size());
  std::transform(ours.cpu_s.begin(), ours.cpu_s.end(), peer.cpu_s.begin(), each.begin(), std::divides<>());
  return median(each);
}

/// A row of the table of tools/bench/run: a line of JSON.
/// @param ratio  ours over the peer's, where less is better; of speeds the other way round where more is
/// asked
inline void tell(const char* row, const char* unit, double ours, const char* peer, double peers,
                 double ratio) {
  std::puts(nlohmann::json{
      {"row", row}, {"unit", unit}, {"ours", ours}, {"peer", peer}, {"peers", peers}, {"ratio", ratio}}
                .dump()
                .c_str());
  std::fflush(stdout);
}

}  // namespace roadbalance::bench

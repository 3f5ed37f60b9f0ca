#include "common/dsp/lanes.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "common/dsp/decimating_filter.hpp"
#include "common/dsp/fractional_delay.hpp"
#include "common/dsp/linear_filter.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/dsp/weighted_sum.hpp"

namespace roadbalance {
namespace {

void at_most(int lanes) {
  setenv(kMostLanesVariable, std::to_string(lanes).c_str(), 1);
}

TEST(Lanes, AreThoseOfTheProcessorOrFewerWhereATestAsks) {
  const auto chosen = [] {
    return for_this_processor<int()>(
        +[] { return 8; }, +[] { return 4; }, +[] { return 2; })();
  };
  unsetenv(kMostLanesVariable);
  const int widest = widest_lanes();
  EXPECT_EQ(chosen(), widest);
  for (const int lanes : {2, 4, 8}) {
    at_most(lanes);
    EXPECT_EQ(chosen(), std::min(lanes, widest));
  }
  unsetenv(kMostLanesVariable);
}

/// Filtered noise, on up to 13 channels, so that no width divides them.
std::vector<double> filtered() {
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  std::vector<double> results;
  const auto add = [&results](const auto& values) {
    results.insert(results.end(), values.data(), values.data() + values.size());
  };
  for (Eigen::Index channels = 1; channels <= 13; ++channels) {
    StateFilter filter(discretise_ramp_invariant(butterworth(5, 15.0), 1.0 / 500.0), channels);
    for (int k = 0; k < 50; ++k)
      add(filter.update(Eigen::ArrayXd::NullaryExpr(channels, [&] { return noise(random); })));
    const auto columns = Eigen::MatrixXd::NullaryExpr(channels, 11, [&] { return noise(random); }).eval();
    const auto weight = Eigen::VectorXd::NullaryExpr(11, [&] { return noise(random); }).eval();
    Eigen::VectorXd sum(channels);
    weighted_sum(columns, weight, sum);
    add(sum);
    DecimatingFilter low_pass(channels, 3, weight);
    for (int k = 0; k < 50; ++k)
      if (low_pass.add(Eigen::VectorXd::NullaryExpr(channels, [&] { return noise(random); })))
        add(low_pass.output().eval());
  }
  for (double fraction = 0.0; fraction < 1.0; fraction += 0.0137) add(FractionalDelay().taps(fraction));
  return results;
}

/// The same in a process of its own: kernels are chosen once.
std::vector<double> filtered_with(int lanes) {
  int ends[2] = {};
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    at_most(lanes);
    const std::vector<double> results = filtered();
    const auto* bytes = reinterpret_cast<const char*>(results.data());
    std::size_t left = results.size() * sizeof(double);
    for (ssize_t n = 1; left > 0 && n > 0; bytes += n, left -= static_cast<std::size_t>(n))
      n = write(ends[1], bytes, left);
    _exit(0);
  }
  close(ends[1]);
  std::vector<double> results;
  double value = 0.0;
  char* const to = reinterpret_cast<char*>(&value);
  for (std::size_t have = 0;;) {
    const ssize_t n = read(ends[0], to + have, sizeof value - have);
    if (n <= 0) break;
    have += static_cast<std::size_t>(n);
    if (have < sizeof value) continue;
    results.push_back(value);
    have = 0;
  }
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return results;
}

// Nodes, hosts and all machines of a cluster filter alike (CMakeLists.txt): a replay gives the same bits.
TEST(Lanes, FilterToTheSameBitsWhateverTheirNumber) {
  const auto plain = filtered_with(2);
  ASSERT_GT(plain.size(), 1000U);
  EXPECT_EQ(filtered_with(4), plain);
  EXPECT_EQ(filtered_with(8), plain);
}

}  // namespace
}  // namespace roadbalance

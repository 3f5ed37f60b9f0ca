#include <gtest/gtest.h>

#include <random>

#include "common/dsp/cross_spectra.hpp"
#include "common/dsp/transfer_function.hpp"

namespace roadbalance {
namespace {

Eigen::MatrixXd white(int channels, Eigen::Index samples, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(channels, samples, [&] { return normal(random); });
}

TEST(MeanDelay, IsTheDelayOfItsOutput) {
  constexpr double kRate_hz = 1000.0;
  const Eigen::MatrixXd x = white(2, 40'000, 8);
  Eigen::MatrixXd signals(2, x.cols());
  signals.row(0) = x.row(0);
  signals.row(1).setZero();
  signals.row(1).tail(x.cols() - 3) = 0.5 * x.row(0).head(x.cols() - 3);
  signals.row(1) += 0.5 * x.row(1);
  CrossSpectra spectra({.welch = {.rate_hz = kRate_hz, .segment = 512}, .channels = 2});
  spectra.add(signals);
  const auto delay = [&](int input, int output) {
    return mean_delay_s(transfer_function(spectra.density(input), spectra.density(output),
                                          spectra.density(input, output), spectra.independent_averages()),
                        spectra.step_hz());
  };
  ASSERT_TRUE(delay(0, 1));
  // Coherence 0.5 and 80 averages determine each phase to 0.08 rad; slopes from bin to bin add up to that of
  // the first to the last, 0.11 rad over 500 Hz: 36 us, and somewhat more by unequal weights.  Four sigma.
  EXPECT_NEAR(*delay(0, 1), 3.0 / kRate_hz, 2e-4);
  EXPECT_NEAR(*delay(1, 0), -3.0 / kRate_hz, 2e-4);
  EXPECT_FALSE(mean_delay_s({}, 1.0)) << "no bin tells";
}

}  // namespace
}  // namespace roadbalance

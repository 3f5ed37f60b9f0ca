#include "tools/study/phase_injection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace roadbalance {
namespace {

TEST(PhaseInjection, ComesBackWithinATwentiethOfADegreeThroughEveryFilter) {
  const auto rows = phase_injection_rows();
  EXPECT_EQ(rows.size(), 6U);
  for (const auto& row : rows) EXPECT_TRUE(row["met"].get<bool>()) << row.dump();
}

TEST(PhaseInjection, CountsWhatIsNoNumberAndLeavesItOutOfTheMean) {
  const double nan = std::nan("");
  const auto row = phase_row("some", {0.01, nan, -0.03});
  EXPECT_EQ(row["unknown_blocks"], 1);
  EXPECT_NEAR(row["rms_deg"], std::sqrt((1e-4 + 9e-4) / 2.0), 1e-12);
  EXPECT_NEAR(row["max_deg"], 0.03, 1e-12);
  EXPECT_FALSE(row["met"]);
  EXPECT_TRUE(phase_row("all", {0.01, -0.03})["met"]);
  EXPECT_FALSE(phase_row("none", {nan})["met"]);
}

// The simulated conditioner steps twice a scan, the reference at least at 4 kHz: here they differ.
TEST(PhaseInjection, ComesBackAtOtherScanRates) {
  for (const double rate_hz : {1000.0, 1500.0, 4000.0})
    EXPECT_NEAR(injected_phase_error_deg({.filter = {5, 150.0}, .turns_hz = 25.0, .scan_rate_hz = rate_hz}),
                0.0, 0.05)
        << rate_hz;
}

TEST(PhaseInjection, AnyPhaseComesBack) {
  for (const double phase_rad : {-3.0, -1.0, 0.0, 2.0})
    EXPECT_NEAR(injected_phase_error_deg({.filter = {6, 200.0}, .turns_hz = 18.0, .phase_rad = phase_rad}),
                0.0, 0.05)
        << phase_rad;
}

// 5 km/h a minute on wheels of 0.3 m are 0.0123 turns a second a second.
TEST(PhaseInjection, ADriftingSpeedCostsNothingByTheReferenceAndMuchByAConstantFrequency) {
  PhaseInjection injection{.filter = {6, 200.0}, .turns_hz = 18.0};
  const auto steady = injected_over_sent(injection);
  injection.drift_turns_s2 = 0.0123;
  const auto drifting = injected_over_sent(injection) / steady;
  EXPECT_NEAR(std::abs(drifting), 1.0, 0.001);
  EXPECT_NEAR(std::arg(drifting) * 180.0 / std::numbers::pi, 0.0, 0.05);
  injection.drift_turns_s2 = 10 * 0.0123;
  // The mean of e^{j pi drift t^2} over 8 s under the same window: 0.70.
  std::complex<double> sum = 0.0;
  for (double t = -4.0; t < 4.0; t += 0.001)
    sum += 0.001 / 4.0 * std::pow(std::cos(std::numbers::pi * t / 8.0), 2) *
           std::polar(1.0, std::numbers::pi * injection.drift_turns_s2 * t * t);
  EXPECT_NEAR(std::abs(injected_over_sent(injection, true)), std::abs(sum), 0.005);
  EXPECT_LT(std::abs(sum), 0.75);
  EXPECT_NEAR(std::abs(injected_over_sent(injection) / steady), 1.0, 0.001);
}

TEST(PhaseInjection, ALagThatNothingCorrectsIsSeen) {
  const double error =
      injected_phase_error_deg({.filter = {6, 200.0}, .turns_hz = 25.0, .sine_late_s = 100e-6});
  EXPECT_NEAR(error, 360.0 * 25.0 * 100e-6, 0.05);
}

}  // namespace
}  // namespace roadbalance

#include "tools/study/phase_injection.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace roadbalance {
namespace {

TEST(PhaseInjection, ComesBackWithinATwentiethOfADegreeThroughEveryFilter) {
  const auto rows = phase_injection_rows();
  EXPECT_EQ(rows.size(), 5U);
  for (const auto& row : rows) EXPECT_TRUE(row["met"].get<bool>()) << row.dump();
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

TEST(PhaseInjection, ALagThatNothingCorrectsIsSeen) {
  const double error =
      injected_phase_error_deg({.filter = {6, 200.0}, .turns_hz = 25.0, .sine_late_s = 100e-6});
  EXPECT_NEAR(error, 360.0 * 25.0 * 100e-6, 0.05);
}

}  // namespace
}  // namespace roadbalance

// Free-running converters, from the simulated car to the estimate.
#include <gtest/gtest.h>

#include <cmath>

#include "tools/study/demo_accuracy.hpp"

namespace roadbalance {
namespace {

TEST(ConverterDrive, NodesWhoseConvertersDriftApartGiveTheSameEstimate) {
  constexpr double kDrive_s = 160.0;
  const auto nominal = demo_accuracy_run(3, kDrive_s);
  // After the drive the two are 19 samples apart: 10 ms, or 60 degrees at 18 Hz.
  const auto drifting = demo_accuracy_run(3, kDrive_s, {70.0, -50.0});
  for (std::size_t w = 0; w < 4; ++w) {
    const auto& a = nominal["wheels"][w];
    const auto& b = drifting["wheels"][w];
    ASSERT_TRUE(a["unbalance_g"].is_number() && b["unbalance_g"].is_number()) << a << b;
    // The noise of the sensors is that of other instants, and sections begin at others; nothing else differs.
    const double sigma_g = a["sigma_g"], sigma_deg = a["sigma_deg"];
    const double sigma_n_m = a["sigma_tyre_stiffness_n_m"];
    EXPECT_NEAR(a["unbalance_g"].get<double>(), b["unbalance_g"].get<double>(), sigma_g) << a << b;
    EXPECT_NEAR(std::remainder(a["angle_deg"].get<double>() - b["angle_deg"].get<double>(), 360.0), 0.0,
                sigma_deg)
        << a << b;
    EXPECT_NEAR(a["tyre_stiffness_n_m"].get<double>(), b["tyre_stiffness_n_m"].get<double>(), sigma_n_m)
        << a << b;
  }
}

}  // namespace
}  // namespace roadbalance

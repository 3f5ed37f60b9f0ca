#include "host/analysis/twin/sample_history.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/test/source.hpp"
#include "host/analysis/twin/test/known_drive.hpp"

namespace roadbalance {
namespace {

using test::KnownDrive;

TEST(SampleHistory, AnAngleThatWasLostForAWhileLeavesTheForceOfUnbalanceBesideItAsItIs) {
  const VehicleConfig vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  const TwinChannels channels = TwinChannels::of(vehicle);
  TwinCar car = TwinCar::nominal(vehicle);
  car.unbalance_kg_m = test::kReferenceUnbalance;
  const KnownDrive drive(test::reference_car());
  SampleHistory history(channels, KnownDrive::kRate_hz);
  constexpr int kLost = 400, kFound = 440, kEnd = 900;
  const auto n = static_cast<Eigen::Index>(channels.channel.size());
  for (int k = 0; k < kEnd; ++k) {
    SensorSample sample = drive.sample(channels, k);
    if (k >= kLost && k < kFound) sample.values.segment<2>(n).setZero();  // of the first wheel alone
    history.add(sample, car);
  }

  const double turning = KnownDrive::kSpeed_m_s / KnownDrive::kRadius_m;
  for (std::int64_t k = SampleHistory::kHalfRate; k < history.end_of_drive(); ++k)
    for (std::size_t w = 0; w < kWheels; ++w) {
      const auto reference = KnownDrive::angle(w, static_cast<double>(k) / KnownDrive::kRate_hz);
      const double force = (car.unbalance_kg_m[w] * turning * turning * reference).real();
      const bool is_lost = w == 0 && k >= kLost && k < kFound;
      EXPECT_NEAR(history.forces(k)(static_cast<Eigen::Index>(w)), is_lost ? 0.0 : force,
                  1e-9 * std::abs(car.unbalance_kg_m[w]) * turning * turning)
          << "wheel " << w << ", sample " << k;
    }
}

}  // namespace
}  // namespace roadbalance

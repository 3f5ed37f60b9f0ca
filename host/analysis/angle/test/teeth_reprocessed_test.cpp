// References of a drive's recorded edges against those that the node computed live, both against the angle
// that the edges were made of.
#include "host/analysis/angle/angle_reprocessor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "common/bus/codec.hpp"
#include "common/types/angle_sigma.hpp"
#include "firmware/test/butterworth.hpp"
#include "firmware/test/sealed_epoch.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;

class TeethAgain : public testing::Test {
 protected:
  static constexpr double kSeconds = 20.0;

  /// How far the references are from the truth after the filter's lag, rms over what is known.
  double error_deg(const std::vector<SealedBlock>& blocks) const {
    double square = 0.0, count = 0.0;
    for (const SealedBlock& block : blocks) {
      if (block.kind != BlockKind::kScan) continue;
      const ScanBlock scans = decode_scan(block);
      if ((scans.quality & kQualityNoReference0) != 0) continue;
      for (std::int64_t row = 0; row < scans.header.scans; ++row) {
        const auto& counts = scans.counts[static_cast<std::size_t>(row)];
        const std::complex<double> reference(counts[kAccelerations + 1], counts[kAccelerations]);
        const double t = static_cast<double>(scans.row_time_ns(row)) * 1e-9;
        const double error =
            std::arg(reference * std::polar(1.0, -train.angle_rad(t) + kLag_rad)) * 180.0 / pi;
        square += error * error;
        count += 1.0;
      }
    }
    EXPECT_GT(count, 0.9 * kSeconds * test::kRate_hz);
    return std::sqrt(square / count);
  }
  const VehicleConfig vehicle = test::one_node_vehicle(test::kRate_hz);
  const double kLag_rad = -std::arg(test::response(vehicle.filter, 18.0));
  const sim::PulseTrain train{.angle_rad = [](double t) { return 2.0 * pi * 18.0 * t + 1.0; },
                              .pitch_error_rad = sim::pitch_errors(96, 0.3 * pi / 180.0, 5),
                              .jitter_s = 20e-6};
  const std::vector<SealedBlock> live = test::blocks_of(
      test::marked_scans(0, static_cast<std::int64_t>(kSeconds* test::kRate_hz), test::kRate_hz),
      train.edges(0.0, kSeconds));

  std::vector<SealedBlock> reprocess(AngleReprocessor& angles) const {
    for (const SealedBlock& block : live) angles.learn(block);
    std::vector<SealedBlock> blocks;
    for (const SealedBlock& block : live) blocks.push_back(angles.reprocess(block));
    return blocks;
  }
};

TEST_F(TeethAgain, AreNearerToTheTruthThanLive) {
  AngleReprocessor angles(vehicle, AngleReprocessor::WithoutMark::kNoAngle, AngleReprocessor::Teeth::kAgain);
  ASSERT_TRUE(angles.wanted());
  const auto computed_again = reprocess(angles);
  const double before = error_deg(live), after = error_deg(computed_again);
  EXPECT_LT(after, 0.8 * before);
  const auto quality = angles.quality(0);
  ASSERT_TRUE(quality && quality->located);
  EXPECT_EQ(quality->marks, 360);  // 20 s at 18 turns a second
  // 20 us are 0.13 degrees a mark, and so much less in the mean of all.
  EXPECT_NEAR(quality->common_sigma_rad * 180.0 / pi, 0.13 / std::sqrt(360.0), 0.002);
  EXPECT_LT(after, 3.0 * quality->sigma_rad * 180.0 / pi);
  // The blocks hold it rounded up by half an octave at most, and not the node's live value.
  double square = 0.0, scans = 0.0;
  for (const SealedBlock& block : computed_again) {
    if (block.kind != BlockKind::kScan) continue;
    const auto told = angle_sigma_rad(decode_scan(block).quality, 0);
    if (!told) continue;
    square += *told * *told * static_cast<double>(block.header.scans);
    scans += static_cast<double>(block.header.scans);
  }
  EXPECT_GT(scans, 0.9 * kSeconds * test::kRate_hz);
  const double told = std::sqrt(square / scans) / quality->sigma_rad;
  EXPECT_GT(told, 1.0 - 1e-6);
  EXPECT_LT(told, std::sqrt(2.0) + 1e-6);
}

TEST_F(TeethAgain, StayAsTheyAreUnlessItIsWanted) {
  AngleReprocessor angles(vehicle);
  EXPECT_FALSE(angles.wanted());
  EXPECT_FALSE(angles.quality(0));
}

}  // namespace
}  // namespace roadbalance

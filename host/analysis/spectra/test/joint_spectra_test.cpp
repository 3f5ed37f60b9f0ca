#include "host/analysis/spectra/joint_spectra.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "common/dsp/transfer_function.hpp"
#include "host/analyser/test/noise_drive.hpp"

namespace roadbalance {
namespace {

using test::car, test::kFront, test::kRear, test::NoiseDrive;

JointSpectra both(int segment) {
  return {car(), {kFront, kRear}, {.segment = segment}};
}

TEST(JointSpectra, ChannelsOfDifferentNodesHaveATransferFunction) {
  JointSpectra joint = both(200);
  NoiseDrive drive;
  for (int i = 0; i < 200; ++i)
    for (const int node : {1, 0}) joint.consume(drive.next(node));
  EXPECT_EQ(joint.runs(), 1);
  EXPECT_EQ(joint.end_ns(), (200 * kScansPerBlock - 1) * test::kPeriodNs);
  const CrossSpectra& spectra = joint.spectra();
  EXPECT_EQ(spectra.averages(), 39);  // 4000 samples, 200 at a time, half over half
  const TransferFunction h = transfer_function(spectra.density(0), spectra.density(1), spectra.density(0, 1),
                                               spectra.independent_averages());
  for (std::size_t k = 2; k < 99; ++k) {
    // Three samples of delay: a segment's ends are not common, of 200 samples under Hann's window.
    const double turn = -2.0 * std::acos(-1.0) * 10.0 * static_cast<double>(k) * 3.0 / 2000.0;
    EXPECT_LT(std::abs(h.h1[k] - std::polar(0.5, turn)), 0.02) << k;
    EXPECT_GT(h.coherence[k], 0.99) << k;
  }
}

TEST(JointSpectra, NoSegmentRunsAcrossAHoleOfAnyNode) {
  JointSpectra joint = both(100);
  NoiseDrive drive;
  for (int i = 0; i < 9; ++i) {
    joint.consume(drive.next(0));
    const SealedBlock rear = drive.next(1);
    if (i != 4) joint.consume(rear);  // lost
  }
  EXPECT_EQ(joint.runs(), 2);
  EXPECT_EQ(joint.spectra().averages(), 0) << "80 samples before the hole, 80 after it";
  joint.consume(drive.next(0));
  joint.consume(drive.next(1));
  EXPECT_EQ(joint.spectra().averages(), 1);
}

TEST(JointSpectra, AChannelThatLeftItsRangeIsAHoleAnotherIsNot) {
  for (const int overloaded : {kRear.channel, kRear.channel + 1}) {
    JointSpectra joint = both(100);
    NoiseDrive drive;
    for (int i = 0; i < 5; ++i) {
      joint.consume(drive.next(0));
      joint.consume(drive.next(1, i == 2 ? 1 << overloaded : 0));
    }
    EXPECT_EQ(joint.spectra().averages(), overloaded == kRear.channel ? 0 : 1);
  }
}

}  // namespace
}  // namespace roadbalance

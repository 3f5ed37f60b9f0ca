#include "host/analysis/identify/stretch_collector.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/test/source.hpp"

namespace roadbalance {
namespace {

const VehicleConfig& car() {
  static const VehicleConfig vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  return vehicle;
}

class Drive {
 public:
  Drive() : collector_(car(), [this](const Stretch& stretch) { stretches.push_back(stretch); }) {}

  void at(double speed_m_s, int seconds, bool angle = true, bool restart = false, bool spoiled = false) {
    for (int k = 0; k < seconds * 500; ++k) {
      IdentificationSample sample;
      sample.signals.setConstant(1.0);
      sample.restart = restart && k == 0;
      sample.spoiled = spoiled && k == 0;
      if (road) sample.road_m = Eigen::Vector4d(0.01, 0.02, 0.03, 0.04);
      angle_ += speed_m_s / 0.30 / 500.0;
      for (int i = 0; i < kWheels; ++i) {
        sample.signals(cosine_row(i)) = angle || i != 2 ? std::cos(angle_) : 0.0;
        sample.signals(sine_row(i)) = angle || i != 2 ? std::sin(angle_) : 0.0;
      }
      collector_.consume(sample);
    }
  }
  void end() { collector_.finish(); }

  std::vector<Stretch> stretches;
  bool road = false;

 private:
  StretchCollector collector_;
  double angle_ = 0.3;
};

TEST(StretchCollector, EndsAStretchWhereTheSpeedChanges) {
  Drive drive;
  drive.at(25.0, 23, true, true);  // 3 s of it settle
  drive.at(30.0, 15);
  drive.end();
  ASSERT_EQ(drive.stretches.size(), 2u);
  EXPECT_EQ(drive.stretches[0].signals.cols(), 20 * 500);
  EXPECT_NEAR(drive.stretches[0].speed_m_s, 25.0, 1e-9);
  for (int i = 0; i < kWheels; ++i) EXPECT_NEAR(drive.stretches[0].omega(i), 25.0 / 0.30, 1e-9);
  EXPECT_EQ(drive.stretches[1].signals.cols(), 15 * 500);
  EXPECT_NEAR(drive.stretches[1].speed_m_s, 30.0, 1e-9);
  EXPECT_EQ(drive.stretches[0].road_m.cols(), 0);
}

TEST(StretchCollector, HandsOverNothingThatASensorHasSpoiled) {
  Drive drive;
  drive.at(25.0, 23, true, true);
  drive.at(25.0, 18, true, true, true);
  drive.end();
  ASSERT_EQ(drive.stretches.size(), 1u);
  EXPECT_EQ(drive.stretches[0].signals.cols(), 15 * 500) << "what came behind it, but 3 s that settle";
}

TEST(StretchCollector, EndsAStretchAtAHoleAndDropsWhatIsTooShort) {
  Drive drive;
  drive.at(25.0, 15, true, true);  // 12 s after settling
  drive.at(25.0, 12, true, true);  // 9 s: too short
  drive.at(25.0, 14, true, true);
  drive.end();
  ASSERT_EQ(drive.stretches.size(), 2u);
  EXPECT_EQ(drive.stretches[0].signals.cols(), 12 * 500);
  EXPECT_EQ(drive.stretches[1].signals.cols(), 11 * 500);
}

TEST(StretchCollector, LeavesOutWhatLacksAnAngleOrIsTooSlow) {
  Drive drive;
  drive.at(25.0, 15, true, true);
  drive.at(25.0, 5, false);
  drive.at(25.0, 13);
  drive.at(10.0, 20);
  drive.end();
  ASSERT_EQ(drive.stretches.size(), 2u);
  EXPECT_EQ(drive.stretches[0].signals.cols(), 12 * 500);
  EXPECT_EQ(drive.stretches[1].signals.cols(), 13 * 500);
}

TEST(StretchCollector, KeepsAtMostAMinuteAndTheRoad) {
  Drive drive;
  drive.road = true;
  drive.at(25.0, 83, true, true);
  drive.end();
  ASSERT_EQ(drive.stretches.size(), 2u);
  EXPECT_EQ(drive.stretches[0].signals.cols(), 60 * 500);
  ASSERT_EQ(drive.stretches[0].road_m.cols(), 60 * 500);
  EXPECT_EQ(drive.stretches[0].road_m(2, 77), 0.03);
  EXPECT_EQ(drive.stretches[1].signals.cols(), 20 * 500);
}

}  // namespace
}  // namespace roadbalance

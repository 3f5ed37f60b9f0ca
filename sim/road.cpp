#include "sim/road.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

namespace roadbalance::sim {
namespace {

constexpr double kRunIn_m = 200.0;  ///< 12 times the memory of the lower corner
constexpr double kJoint_m = 0.3, kPothole_m = 0.6;
std::int64_t stretch_number(std::int64_t cell, std::int64_t cells_a_stretch) {
  return cell / cells_a_stretch - (cell < 0 && cell % cells_a_stretch != 0 ? 1 : 0);
}

}  // namespace

RoadFilter::RoadFilter(double roughness_m3) {
  constexpr double kPi = std::numbers::pi;
  const double intensity =
      2.0 * kPi * kPi * kReferenceWaveNumber_1_m * kReferenceWaveNumber_1_m * roughness_m3;
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -kLowCorner_rad_m * kHighCorner_rad_m, -(kLowCorner_rad_m + kHighCorner_rad_m);
  Eigen::Matrix4d block = Eigen::Matrix4d::Zero();
  block.topLeftCorner<2, 2>() = -a;
  block.bottomRightCorner<2, 2>() = a.transpose();
  block(1, 3) = kHighCorner_rad_m * kHighCorner_rad_m;  // unit intensity
  const Eigen::Matrix4d e = (block * kGrid_m).exp();
  transition = e.bottomRightCorner<2, 2>().transpose();
  const Eigen::Matrix2d covariance = transition * e.topRightCorner<2, 2>();
  noise = std::sqrt(intensity) * Eigen::Matrix2d(covariance.llt().matrixL());
}

RoadProfile::RoadProfile(const RoadScenario& scenario, std::uint64_t seed, std::size_t wheel, double start_m)
    : scenario_(scenario),
      filter_(scenario.roughness_m3),
      stretch_(seed, Use::kRoadStretch, 0),
      cells_a_stretch_(std::llround(scenario.stretch_m / RoadFilter::kGrid_m)),
      joints_(scenario.joint, kJoint_m, 1.0, {seed, Use::kObstacle, 2}),
      potholes_(scenario.pothole, kPothole_m, -1.0, {seed, Use::kObstacle, wheel % 2}),
      cell_(static_cast<std::int64_t>(std::floor((start_m - kRunIn_m) / RoadFilter::kGrid_m))),
      from_(Eigen::Vector2d::Zero()),
      to_(Eigen::Vector2d::Zero()) {
  // Sequences 0, 1 are those of the front axle's left and right track, 2, 3 what the rear axle adds.
  const double coherence = std::sqrt(scenario.rear_coherence2);
  const double alone = std::sqrt(1.0 - scenario.rear_coherence2);
  const double both_sides = scenario.left_right_correlation;
  const double one_side = std::sqrt(1.0 - both_sides * both_sides);
  const bool right = wheel % 2 == 1;
  const auto add = [&](std::uint64_t first, double weight) {
    ingredient_.push_back({{seed, Use::kRoad, first}, right ? both_sides * weight : weight, false});
    if (right) ingredient_.push_back({{seed, Use::kRoad, first + 1}, one_side * weight, true});
  };
  if (scenario.roughness_m3 == 0.0) return;  // no ingredient: flat but for its obstacles
  if (wheel < 2) {
    add(0, 1.0);
  } else {
    add(0, coherence);
    add(2, alone);
  }
  begin_stretch(stretch_number(cell_, cells_a_stretch_));
}

void RoadProfile::begin_stretch(std::int64_t number) {
  const double bent = scenario_.stretch_waviness * (2.0 * stretch_.uniform(2 * number) - 1.0);
  const double height = std::pow(scenario_.stretch_height, 2.0 * stretch_.uniform(2 * number + 1) - 1.0);
  Waviness waviness = scenario_.waviness;
  waviness.below += bent;
  waviness.above += bent;
  lefts_.set(waviness, height);
  waviness.below += scenario_.right_waviness;
  waviness.above += scenario_.right_waviness;
  rights_.set(waviness, height);
}

void RoadProfile::advance() {
  ++cell_;
  from_ = to_;
  if (cell_ % cells_a_stretch_ == 0) begin_stretch(stretch_number(cell_, cells_a_stretch_));
  Eigen::Vector2d lefts = Eigen::Vector2d::Zero(), rights = lefts;
  for (const Ingredient& i : ingredient_)
    (i.is_rights ? rights : lefts) +=
        i.weight * Eigen::Vector2d(i.random.normal(2 * cell_), i.random.normal(2 * cell_ + 1));
  to_ = filter_.transition * from_ + filter_.noise * (lefts_.filter(lefts) + rights_.filter(rights));
}

RoadPoint RoadProfile::at(double place_m) {
  RoadPoint point = joints_.at(place_m);
  point += potholes_.at(place_m);
  if (ingredient_.empty()) return point;
  const double cells = place_m / RoadFilter::kGrid_m;
  while (cells >= static_cast<double>(cell_ + 1)) advance();
  // Cubic Hermite curve through height and slope at both grid points.
  const double x = cells - static_cast<double>(cell_);
  const double rise_m = to_(0) - from_(0);
  const double a = RoadFilter::kGrid_m * from_(1);
  const double b = RoadFilter::kGrid_m * to_(1);
  const double c2 = 3.0 * rise_m - 2.0 * a - b;
  const double c3 = a + b - 2.0 * rise_m;
  return point +=
         {from_(0) + x * (a + x * (c2 + x * c3)), (a + x * (2.0 * c2 + 3.0 * x * c3)) / RoadFilter::kGrid_m,
          (2.0 * c2 + 6.0 * x * c3) / (RoadFilter::kGrid_m * RoadFilter::kGrid_m)};
}

}  // namespace roadbalance::sim

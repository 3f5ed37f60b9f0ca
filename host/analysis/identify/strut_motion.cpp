#include "host/analysis/identify/strut_motion.hpp"

#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

constexpr double kStrutHighPass_hz = 0.1;

}  // namespace

Eigen::Matrix<double, kWheels, kCoordinates> strut_stretch(const Geometry& geometry) {
  Eigen::Matrix<double, kWheels, kCoordinates> stretch;
  for (int i = 0; i < kWheels; ++i)
    // The damping matrix of a unit damper is B' B, B the row of its stretch, with -1 at its own wheel.
    stretch.row(i) =
        -linear_model(geometry, ParameterVector::Unit(kDamper + i)).P.col(kBodyCoordinates + i).transpose();
  return stretch;
}

StrutMotion::StrutMotion(const Eigen::Ref<const Eigen::MatrixXd>& stretch, double rate_hz)
    : stretch_(stretch),
      velocity_(discretise_ramp_invariant(butterworth(3, kStrutHighPass_hz), 1.0 / rate_hz), kWheels) {}

void StrutMotion::update(const Eigen::Ref<const Eigen::ArrayXd>& acceleration,
                         Eigen::Ref<Eigen::ArrayXd> signals) {
  const auto state = velocity_.update((stretch_ * acceleration.matrix()).array());
  const auto rate = (state.col(2) + 2.0 * state.col(1)) / (kTurn * kStrutHighPass_hz);
  signals.head<kWheels>() = (rate / kSmooth_m_s).tanh();
  signals.tail<kWheels>() = rate.abs();
}

}  // namespace roadbalance

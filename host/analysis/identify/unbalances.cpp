#include "host/analysis/identify/unbalances.hpp"

#include <Eigen/LU>
#include <complex>

namespace roadbalance {
namespace {

/// Right side of the normal equations, contribution of the force on one wheel.
Eigen::Vector4cd right_side(const HarmonicMoments& moments, const LinearModel& model, int wheel) {
  Eigen::Vector4cd right;
  for (int i = 0; i < kWheels; ++i)
    right(i) = moments.right[static_cast<std::size_t>(i)][static_cast<std::size_t>(wheel)].force(
        model, kBodyCoordinates + wheel);
  return right;
}

}  // namespace

LinearModel unit_model(const Geometry& geometry, int parameter) {
  ParameterVector unit = ParameterVector::Zero();
  unit(parameter) = 1.0;
  return linear_model(geometry, unit);
}

Eigen::Matrix4cd inverse_where_known(const Eigen::Matrix4cd& normal) {
  Eigen::Matrix4cd filled = normal;
  for (int i = 0; i < kWheels; ++i)
    if (normal(i, i) == 0.0) filled(i, i) = 1.0;
  Eigen::Matrix4cd inverse = filled.inverse();
  for (int i = 0; i < kWheels; ++i)
    if (normal(i, i) == 0.0) inverse(i, i) = 0.0;
  return inverse;
}

Unbalances solve_unbalances(const HarmonicMoments& moments, const Geometry& geometry,
                            const ParameterVector& without_tyres, const std::bitset<kWheels>& asked) {
  Unbalances result;
  Eigen::Matrix4cd normal = moments.normal;
  for (int i = 0; i < kWheels; ++i) {
    if (!asked[static_cast<std::size_t>(i)]) {
      normal.row(i).setZero();
      normal.col(i).setZero();
    }
    result.found[static_cast<std::size_t>(i)] = normal(i, i) != 0.0;
  }
  result.covariance = inverse_where_known(normal);
  const LinearModel known = linear_model(geometry, without_tyres);
  result.without_tyres.setZero();
  for (int j = 0; j < kWheels; ++j) {
    result.without_tyres += result.covariance * right_side(moments, known, j);
    result.per_tyre.col(j) = result.covariance * right_side(moments, unit_model(geometry, kTyre + j), j);
  }
  return result;
}

}  // namespace roadbalance

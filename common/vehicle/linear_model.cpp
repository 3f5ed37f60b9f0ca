#include "common/vehicle/linear_model.hpp"

#include "derived/seven_dof.hpp"

namespace roadbalance {
namespace {

template <int Rows, int Columns>
auto matrix(const double (&entries)[Rows][Columns]) {
  return Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>>(entries[0]);
}

}  // namespace

Geometry geometry_of(const ModelConfig& model) {
  Geometry geometry{};
  for (std::size_t i = 0; i < kWheels; ++i) {
    const AxleConfig& axle = model.axle[i / 2];
    geometry.x_m[i] = axle.x_m;
    geometry.y_m[i] = i % 2 == 0 ? axle.half_track_m : -axle.half_track_m;
  }
  return geometry;
}

ParameterVector nominal_parameters(const VehicleConfig& vehicle) {
  ParameterVector p;
  p(kBodyMass) = vehicle.model.body_mass_kg;
  p(kRollInertia) = vehicle.model.roll_inertia_kg_m2;
  p(kPitchInertia) = vehicle.model.pitch_inertia_kg_m2;
  for (int i = 0; i < kWheels; ++i) {
    const AxleConfig& axle = vehicle.model.axle[static_cast<std::size_t>(i / 2)];
    p(kWheelMass + i) = vehicle.wheel[static_cast<std::size_t>(i)].mass_kg;
    p(kSpring + i) = axle.spring_n_m;
    p(kDamper + i) = axle.damper_n_s_m;
    p(kTyre + i) = axle.tyre_n_m;
    p(kTyreDamper + i) = axle.tyre_damper_n_s_m;
  }
  for (int a = 0; a < kAxles; ++a)
    p(kStabiliser + a) = vehicle.model.axle[static_cast<std::size_t>(a)].stabiliser_n_m;
  return p;
}

LinearModel linear_model(const Geometry& geometry, const ParameterVector& p) {
  static_assert(seven_dof::kCoordinates == kCoordinates && seven_dof::kTyres == kWheels &&
                seven_dof::kGeometryCount == 2 * kWheels &&
                seven_dof::kParameterCount == kParameters + 2 * kWheels);
  // Behind the car's parameters come the unbalances: cosine[4], of which 1 makes T that of a force, and
  // sine[4].
  Eigen::Matrix<double, seven_dof::kParameterCount, 1> parameters;
  parameters << p, Eigen::Vector4d::Ones(), Eigen::Vector4d::Zero();
  Eigen::Matrix<double, seven_dof::kGeometryCount, 1> places;
  places << Eigen::Map<const Eigen::Vector4d>(geometry.x_m.data()),
      Eigen::Map<const Eigen::Vector4d>(geometry.y_m.data());
  const seven_dof::Equations e = seven_dof::equations(parameters.data(), places.data());
  LinearModel m;
  m.M = matrix(e.M);
  m.P = matrix(e.P);
  m.Q = matrix(e.Q);
  m.S = matrix(e.S);
  m.Sd = matrix(e.Sd);
  for (int i = 0; i < kWheels; ++i) m.W.col(i) = matrix(e.T).col(2 * i + 1);
  return m;
}

}  // namespace roadbalance

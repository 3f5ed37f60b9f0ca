#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/multibody/equations.hpp"

namespace roadbalance {

/// Numbers for M q'' + P q' + Q q = T d + S u + Sd u'  (equations.hpp).
struct ModelMatrices {
  Eigen::MatrixXd M, P, Q;  ///< [f x f]
  Eigen::MatrixXd S, Sd;    ///< [f x tyres]
  Eigen::MatrixXd T;        ///< [f x 2 rotors], per Om^2 of the rotor

  ModelMatrices& operator+=(const ModelMatrices& other);
  friend ModelMatrices operator*(double factor, ModelMatrices m);
};

/// The equations as a constant part and one per chosen parameter: all(p) = constant + sum_k p_k of_k.
struct AffineModel {
  std::vector<std::string> coordinate, tyre, rotor, sensor;
  std::vector<std::string> parameter;  ///< the chosen ones
  Eigen::VectorXd nominal;             ///< their values in the description
  ModelMatrices constant;
  std::vector<ModelMatrices> of;
  Eigen::MatrixXd acceleration, tilt;  ///< of the sensors, [sensors x f]

  struct Plane {
    std::string name;
    int rotor;
  };
  std::vector<Plane> plane;
  Eigen::MatrixXd up, forward;  ///< force in a plane to generalised force, [f x planes]

  ModelMatrices at(const Eigen::VectorXd& parameters) const;
};

/// @param chosen  names of parameters; of all others and of the geometry the description's values are taken
/// @throws ConfigError if one is no parameter of the equations or they are not affine in it
AffineModel affine_model(const Equations& equations, const std::vector<std::string>& chosen);
/// Affine in all parameters.
/// @throws as the other
AffineModel affine_model(const Equations& equations);

}  // namespace roadbalance

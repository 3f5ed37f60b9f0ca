#pragma once

#include <string>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "common/multibody/affine_model.hpp"
#include "common/test/source.hpp"

namespace roadbalance::test {

inline Description description(const std::string& name) {
  const bool own = name == "hub_axis" || name == "swing_arm";
  const std::string path =
      std::string("common/multibody/") + (own ? "test/data/" : "descriptions/") + name + ".toml";
  return Description::parse(read_source(path), path);
}

/// With another value of some of its parameters and lengths.
inline Description with(Description description, const std::vector<std::pair<std::string, double>>& values) {
  for (const auto& [name, value] : values)
    for (auto* kind : {&description.parameter, &description.geometry})
      for (NamedValue& one : *kind)
        if (one.name == name) one.value = value;
  return description;
}

/// One of the matrices that test/data/derive_with_sympy.py found, of a parameter or "1".
inline Eigen::MatrixXd sympy_matrix(const nlohmann::json& by_parameter, const std::string& parameter,
                                    Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows, columns);
  if (by_parameter.contains(parameter))
    for (const auto& entry : by_parameter[parameter])
      matrix(entry[0].get<Eigen::Index>(), entry[1].get<Eigen::Index>()) = entry[2].get<double>();
  return matrix;
}

}  // namespace roadbalance::test

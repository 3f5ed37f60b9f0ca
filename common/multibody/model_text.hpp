#pragma once

#include <string>

#include "common/multibody/equations.hpp"

namespace roadbalance {

/// The equations for a report: a fragment for LaTeX with amsmath.
std::string latex_text(const Equations& equations);

/// The equations as a header of C++17 that needs nothing but the standard library, in a namespace of the
/// description's name: kCoordinates, names and values of parameters and geometry, and
///
///     Equations equations(const double* parameter, const double* geometry);
///
/// with the matrices as arrays.  The same text in every run.
std::string cpp_text(const Equations& equations);

/// The description's name as a name of C++: "seven dof" is seven_dof.
std::string cpp_name(const std::string& name);

}  // namespace roadbalance

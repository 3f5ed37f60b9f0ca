#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/multibody/description.hpp"
#include "common/multibody/expression_matrix.hpp"

namespace roadbalance {

/// The equations of motion of a description, symbolic, linear about its equilibrium q = 0:
///
///     M q'' + P q' + Q q = T d + S u + Sd u'                                                     (1)
///
/// f coordinates q, a road height u under each of m tyres, and for each of n rotors, which turn at Om,
/// d = [sin a1, cos a1, sin a2, ...]'.  Derived as d'Alembert's principle in Jourdain's form has it, from the
/// positions r(q) and rotations R(q) of all bodies: with J = dr/dq and J_R the Jacobian of the angular
/// velocity,
///
///     M = sum J' m J + J_R' I J_R,      P = sum d s_q' s_q,
///     Q = sum (k s_q' s_q + f0 s_qq) + sum m g z_qq,      S = sum k z_q',      Sd = sum d z_q'
///
/// over bodies (m, I, height z), springs (k, stretched by s(q), tension f0 at rest) and dampers (d); a tyre
/// is a spring and a damper with s = z - u.  Gyroscopic and centrifugal terms are of second order: bodies do
/// not turn at rest, and wheels are described without their spin.  The tensions f0 balance the weights; where
/// there are more springs than needed, as the four legs of a table have, they are those of the least sum of
/// squares.
struct Equations {
  std::string name;
  std::vector<NamedValue> coordinate;           ///< rows and columns of M, P, Q
  std::vector<NamedValue> parameter, geometry;  ///< symbols that occur
  std::vector<Expression> parameter_symbol, geometry_symbol;
  std::vector<std::string> tyre;   ///< columns of S, Sd
  std::vector<std::string> rotor;  ///< of T: the sine's and the cosine's column for each
  std::vector<UnbalanceDescription> unbalance;
  std::vector<std::string> sensor;

  ExpressionMatrix M, P, Q;  ///< [f x f], symmetric
  ExpressionMatrix S, Sd;    ///< [f x m]
  ExpressionMatrix T;        ///< [f x 2n] divided by Om^2 of its rotor; linear in the unbalances
  /// Vertical and forward force in the plane of each unbalance to generalised force, [f x planes].
  ExpressionMatrix up, forward;
  /// The sensors read `acceleration` q'' + `tilt` q, [sensors x f]; the second is gravity in the direction of
  /// a sensor that turns.
  ExpressionMatrix acceleration, tilt;

  /// Quantities at rest that occur in the matrices and have a name of their own: lengths l of springs and
  /// dampers, of the geometry, and tensions f0, linear in the masses; their factors hold at the description's
  /// geometry only.
  struct AtRest {
    std::string name;
    Expression symbol, value;
  };
  std::vector<AtRest> length, tension;
};

/// @throws ConfigError if a weight is carried by nothing, a coordinate moves no mass, or a formula has no
/// value
Equations derive(const Description& description);

}  // namespace roadbalance

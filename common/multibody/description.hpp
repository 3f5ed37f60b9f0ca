#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/multibody/formula.hpp"

namespace roadbalance {

/// A name set upright, as LaTeX writes it where a description gives no other.
std::string latex_name(const std::string& name);

/// A quantity that formulas name, in SI units.
struct NamedValue {
  std::string name;
  double value = 0.0;
  std::string latex;
};

/// A frame that moves with the coordinates; with its centre of mass in the origin a rigid body.
struct BodyDescription {
  std::string name;
  int on = kGround;                 ///< place in Description::body; its axes are those of `position`
  std::array<Formula, 3> position;  ///< of the origin, m
  std::string axes;                 ///< "x", "y", "z": turned about its own axes, one after the other ...
  std::vector<Formula> angle;       ///< ... by these angles, rad
  Formula mass;                     ///< kg
  std::array<Formula, 3> inertia;   ///< about its axes x, y, z through the origin, kg m^2
  std::array<Formula, 3> product;   ///< of inertia, integrals of xy, yz, zx, kg m^2
  static constexpr int kGround = -1;
};

struct PointDescription {
  std::string name;
  int body;                         ///< place in Description::body, or BodyDescription::kGround
  std::array<Formula, 3> position;  ///< in its axes, m
};

/// The stretch of a spring or damper: the distance of two points, or what the first is ahead of the second
/// along a fixed direction, or a formula of the coordinates.
struct StretchDescription {
  std::array<int, 2> point{-1, -1};  ///< places in Description::point; -1: by the formula
  bool along = false;                ///< along `direction`, not along the line between the points
  std::array<Formula, 3> direction;  ///< in the axes of the ground
  Formula formula;
};

struct SpringDescription {
  std::string name;
  StretchDescription stretch;
  Formula stiffness;  ///< N/m or N m/rad
};
struct DamperDescription {
  std::string name;
  StretchDescription stretch;
  Formula damping;  ///< N s/m or N m s/rad
};
/// A spring that acts on the difference of what two springs are stretched by; at rest without force.
struct StabiliserDescription {
  std::string name;
  std::array<int, 2> spring;  ///< places in Description::spring
  Formula stiffness;
};
/// A tyre between a point and the road below it; each has a road of its own.
struct TyreDescription {
  std::string name;
  int point;
  Formula stiffness;  ///< N/m
  Formula damping;    ///< N s/m
};
/// A plane of a rotor that turns about y, in which an unbalance U = cosine + j sine, kg m, sits
/// (conventions.md).
struct UnbalanceDescription {
  std::string name;
  std::string rotor;  ///< planes of one rotor turn together
  int point;          ///< the plane's centre, on what does not turn
  Formula cosine, sine;
};
/// An accelerometer.
struct SensorDescription {
  std::string name;
  int point;
  std::array<Formula, 3> direction;  ///< in the axes of the point's body, a unit vector
};

/// A vehicle as its equations of motion need it; README.md has the tables and keys.
///
/// It is at rest, and in equilibrium, where all coordinates are 0.
struct Description {
  std::string name;
  double gravity_m_s2 = 9.81;
  std::vector<NamedValue> coordinate;  ///< values 0
  std::vector<NamedValue> parameter;   ///< what identification may ask for
  std::vector<NamedValue> geometry;    ///< what is known
  std::vector<BodyDescription> body;   ///< each on the ground or on one before it
  std::vector<PointDescription> point;
  std::vector<SpringDescription> spring;
  std::vector<DamperDescription> damper;
  std::vector<StabiliserDescription> stabiliser;
  std::vector<TyreDescription> tyre;
  std::vector<UnbalanceDescription> unbalance;
  std::vector<SensorDescription> sensor;

  /// @throws ConfigError "file:line: key: reason"
  static Description parse(const std::string& text, const std::string& name_for_errors);
  /// @throws std::system_error if the file cannot be read; else as parse
  static Description read_file(const std::string& path);

  /// Rotors in the order of their first plane.
  std::vector<std::string> rotors() const;
};

}  // namespace roadbalance

#include "common/multibody/equations.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>
#include <cmath>
#include <exception>
#include <optional>
#include <utility>
#include <vector>

#include "common/config/section.hpp"
#include "common/multibody/expression_matrix.hpp"
#include "common/multibody/kinematics.hpp"

namespace roadbalance {
namespace {

/// Tensions f0 of springs and tyres that balance the weights: slope f0 + weight = 0, of all that do those of
/// the least sum of squares.
struct Equilibrium {
  Eigen::MatrixXd tension_of_weight;        ///< f0 = tension_of_weight weight, [elements x f]
  std::optional<Eigen::Index> not_carried;  ///< a coordinate along which nothing balances the weight
};

/// @param slope   ds/dq at rest of what each element is stretched by, [f x elements]; 0 of what carries
/// nothing
/// @param weight  sum m g dz/dq at rest, N
Equilibrium equilibrium(const Eigen::MatrixXd& slope, const Eigen::VectorXd& weight) {
  Equilibrium result;
  result.tension_of_weight.setZero(slope.cols(), slope.rows());
  if (slope.cols() > 0)
    result.tension_of_weight =
        -Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(slope).pseudoInverse();
  // Without what rounding leaves of 0 and of whole numbers.
  for (double& share : result.tension_of_weight.reshaped()) share = 1e-12 * std::round(1e12 * share);
  const Eigen::VectorXd left = weight + slope * (result.tension_of_weight * weight);
  Eigen::Index worst = 0;
  if (left.cwiseAbs().maxCoeff(&worst) > 1e-9 * weight.cwiseAbs().maxCoeff()) result.not_carried = worst;
  return result;
}

/// Derivatives of the stretch s(q) that springs and dampers act on.
struct StretchDerivatives {
  ExpressionRow slope;         ///< ds/dq at rest
  ExpressionMatrix curvature;  ///< d^2 s / dq^2 at rest
};

/// Derivatives at rest, q = 0.
class Linearisation {
 public:
  explicit Linearisation(const std::vector<Expression>& coordinates);

  Expression at_rest(const Expression& x) const { return x.with(rest_).simplified(); }
  /// dx/dq_i, one entry for each coordinate, in x's unit per that of the coordinate (m or rad).
  ExpressionRow slope(const Expression& x) const;
  /// d^2 x / dq_i dq_j, symmetric, [coordinate x coordinate].
  ExpressionMatrix curvature(const Expression& x) const;

  StretchDerivatives stretch(const Expression& s) const { return {slope(s), curvature(s)}; }
  /// Derivatives of the length of `apart`, which is `length` at rest:
  /// s_i = r r_i / l,  s_ij = (r_i r_j + r r_ij - s_i s_j) / l
  StretchDerivatives of_length(const ExpressionVector& apart, const Expression& length) const;

 private:
  std::vector<Expression> coordinates_;
  std::vector<std::pair<Expression, Expression>> rest_;
};

Linearisation::Linearisation(const std::vector<Expression>& coordinates) : coordinates_(coordinates) {
  for (const Expression& q : coordinates_) rest_.emplace_back(q, Expression(0.0));
}

ExpressionRow Linearisation::slope(const Expression& x) const {
  ExpressionRow row(coordinates_.size());
  for (std::size_t i = 0; i < row.size(); ++i)
    if (x.contains(coordinates_[i])) row[i] = at_rest(x.derivative(coordinates_[i]));
  return row;
}

ExpressionMatrix Linearisation::curvature(const Expression& x) const {
  const std::size_t f = coordinates_.size();
  ExpressionMatrix matrix(f, f);
  for (std::size_t i = 0; i < f; ++i) {
    if (!x.contains(coordinates_[i])) continue;
    const Expression first = x.derivative(coordinates_[i]);
    for (std::size_t j = i; j < f; ++j)
      if (first.contains(coordinates_[j]))
        matrix(i, j) = matrix(j, i) = at_rest(first.derivative(coordinates_[j]));
  }
  return matrix;
}

StretchDerivatives Linearisation::of_length(const ExpressionVector& apart, const Expression& length) const {
  const std::size_t f = coordinates_.size();
  StretchDerivatives result{ExpressionRow(f), ExpressionMatrix(f, f)};
  for (const Expression& part : apart) {
    const Expression r = at_rest(part);
    const ExpressionRow first = slope(part);
    for (std::size_t i = 0; i < f; ++i) result.slope[i] += r * first[i] / length;
    result.curvature.add_product(1.0 / length, first, first);
    result.curvature.add(r / length, curvature(part));
  }
  for (Expression& x : result.slope) x = x.simplified();
  result.curvature.add_product(-1.0 / length, result.slope, result.slope);
  for (std::size_t i = 0; i < f; ++i)
    for (std::size_t j = 0; j < f; ++j) result.curvature(i, j) = result.curvature(i, j).simplified();
  return result;
}

/// Something that force goes through: k s + d s', s = stretch(q) - (height of a road).
struct Element {
  std::string name;
  StretchDerivatives stretch;
  Expression stiffness, damping;
  bool carries = false;  ///< its tension at rest may be other than 0
  int road = -1;
};

class Derivation {
 public:
  explicit Derivation(const Description& description)
      : d_(description),
        names_(description),
        frames_(frames(description, names_)),
        f_(d_.coordinate.size()),
        at_(names_.coordinates()) {
    for (const NamedValue& one : d_.parameter)
      values_.emplace_back(names_.parameters()[values_.size()], one.value);
    for (std::size_t k = 0; k < d_.geometry.size(); ++k)
      values_.emplace_back(names_.geometry()[k], d_.geometry[k].value);
  }

  Equations all() {
    e_.name = d_.name;
    e_.coordinate = d_.coordinate;
    e_.parameter = d_.parameter;
    e_.geometry = d_.geometry;
    e_.parameter_symbol = names_.parameters();
    e_.geometry_symbol = names_.geometry();
    e_.rotor = d_.rotors();
    e_.unbalance = d_.unbalance;
    for (const TyreDescription& tyre : d_.tyre) e_.tyre.push_back(tyre.name);
    for (const SensorDescription& sensor : d_.sensor) e_.sensor.push_back(sensor.name);
    e_.M = e_.P = e_.Q = ExpressionMatrix(f_, f_);
    e_.S = e_.Sd = ExpressionMatrix(f_, d_.tyre.size());
    e_.T = ExpressionMatrix(f_, 2 * e_.rotor.size());
    weight_.assign(f_, Expression(0.0));
    bodies();
    elements();
    unbalances();
    sensors();
    for (ExpressionMatrix* m :
         {&e_.M, &e_.P, &e_.Q, &e_.S, &e_.Sd, &e_.T, &e_.up, &e_.forward, &e_.acceleration, &e_.tilt})
      for (std::size_t i = 0; i < m->rows(); ++i)
        for (std::size_t j = 0; j < m->columns(); ++j) (*m)(i, j) = (*m)(i, j).simplified();
    check_masses();
    return std::move(e_);
  }

 private:
  double number(const Expression& x) const {
    std::vector<std::pair<Expression, Expression>> lengths;
    for (const auto& one : e_.length) lengths.emplace_back(one.symbol, one.value);
    return x.with(lengths).with(values_).number();
  }

  ExpressionVector point(int place) const {
    const PointDescription& p = d_.point[static_cast<std::size_t>(place)];
    return frame(p.body).at(names_(p.position));
  }
  BodyFrame frame(int body) const {
    return body == BodyDescription::kGround ? ground() : frames_[static_cast<std::size_t>(body)];
  }

  void bodies() {
    const Expression g(d_.gravity_m_s2);
    for (std::size_t b = 0; b < d_.body.size(); ++b) {
      const Expression mass = names_(d_.body[b].mass);
      if (!mass.is_zero()) {
        for (const Expression& x : frames_[b].position) {
          const ExpressionRow row = at_.slope(x);
          e_.M.add_product(mass, row, row);
        }
        const StretchDerivatives height = at_.stretch(frames_[b].position[2]);
        for (std::size_t i = 0; i < f_; ++i) weight_[i] += mass * g * height.slope[i];
        e_.Q.add(mass * g, height.curvature);
      }
      add_inertia(d_.body[b], frames_[b].rotation);
    }
  }

  /// J_R in the body's axes: the angular velocity's cross product is R' dR/dq.
  void add_inertia(const BodyDescription& body, const ExpressionRows& rotation) {
    const ExpressionVector inertia = names_(body.inertia), product = names_(body.product);
    std::array<ExpressionRow, 3> rates{ExpressionRow(f_), ExpressionRow(f_), ExpressionRow(f_)};
    ExpressionRows back = transposed(rotation);
    for (ExpressionVector& row : back)
      for (Expression& x : row) x = at_.at_rest(x);
    for (std::size_t i = 0; i < f_; ++i) {
      ExpressionRows change;
      for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c)
          change[r][c] = at_.at_rest(rotation[r][c].derivative(names_.coordinates()[i]));
      const ExpressionRows cross = back * change;
      for (std::size_t a = 0; a < 3; ++a) rates[a][i] = cross[(a + 2) % 3][(a + 1) % 3].simplified();
    }
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3;
      e_.M.add_product(inertia[a], rates[a], rates[a]);
      e_.M.add_product(-product[a], rates[a], rates[b]);
      e_.M.add_product(-product[a], rates[b], rates[a]);
    }
  }

  StretchDerivatives stretch(const std::string& name, const StretchDescription& s) {
    if (s.point[0] < 0) return at_.stretch(names_(s.formula));
    const ExpressionVector apart = point(s.point[0]) - point(s.point[1]);
    if (s.along) return at_.stretch(dot(names_(s.direction), apart));
    Expression length = sqrt(at_.at_rest(dot(apart, apart)));
    if (length.is_sum_below_root()) {
      e_.length.push_back({"length_" + name,
                           Expression::symbol("length_" + name, "l_{" + latex_name(name) + "}", true),
                           length});
      length = e_.length.back().symbol;
    }
    return at_.of_length(apart, length);
  }

  std::vector<Element> all_elements() {
    std::vector<Element> all;
    for (const SpringDescription& s : d_.spring)
      all.push_back(
          {"spring_" + s.name, stretch("spring_" + s.name, s.stretch), names_(s.stiffness), 0.0, true});
    for (const DamperDescription& s : d_.damper)
      all.push_back({"damper_" + s.name, stretch("damper_" + s.name, s.stretch), 0.0, names_(s.damping)});
    for (const StabiliserDescription& s : d_.stabiliser) {
      Element bar{"stabiliser_" + s.name, all[static_cast<std::size_t>(s.spring[0])].stretch,
                  names_(s.stiffness), 0.0};
      for (std::size_t i = 0; i < f_; ++i) {
        const Expression& other = all[static_cast<std::size_t>(s.spring[1])].stretch.slope[i];
        bar.stretch.slope[i] = (bar.stretch.slope[i] - other).simplified();
      }
      all.push_back(std::move(bar));
    }
    for (const TyreDescription& t : d_.tyre)
      all.push_back({"tyre_" + t.name, at_.stretch(point(t.point)[2]), names_(t.stiffness), names_(t.damping),
                     true, static_cast<int>(&t - d_.tyre.data())});
    return all;
  }

  void elements() {
    const std::vector<Element> all = all_elements();
    const std::vector<Expression> tensions = tensions_at_rest(all);
    for (std::size_t n = 0; n < all.size(); ++n) {
      const Element& element = all[n];
      const ExpressionRow& slope = element.stretch.slope;
      e_.Q.add_product(element.stiffness, slope, slope);
      e_.P.add_product(element.damping, slope, slope);
      if (element.road >= 0)
        for (std::size_t i = 0; i < f_; ++i) {
          e_.S(i, static_cast<std::size_t>(element.road)) = element.stiffness * slope[i];
          e_.Sd(i, static_cast<std::size_t>(element.road)) = element.damping * slope[i];
        }
      if (tensions[n].is_zero() || element.stretch.curvature.is_zero()) continue;
      const std::string name = "tension_" + element.name;
      e_.tension.push_back(
          {name, Expression::symbol(name, "f_{" + latex_name(element.name) + "}", false), tensions[n]});
      e_.Q.add(e_.tension.back().symbol, element.stretch.curvature);
    }
  }

  std::vector<Expression> tensions_at_rest(const std::vector<Element>& all) const {
    const auto f = static_cast<Eigen::Index>(f_), n = static_cast<Eigen::Index>(all.size());
    const Eigen::MatrixXd slope = Eigen::MatrixXd::NullaryExpr(f, n, [&](Eigen::Index i, Eigen::Index k) {
      const Element& element = all[static_cast<std::size_t>(k)];
      return element.carries ? number(element.stretch.slope[static_cast<std::size_t>(i)]) : 0.0;
    });
    const Eigen::VectorXd weight = Eigen::VectorXd::NullaryExpr(
        f, [this](Eigen::Index i) { return number(weight_[static_cast<std::size_t>(i)]); });
    const Equilibrium balance = equilibrium(slope, weight);
    if (balance.not_carried)
      fail(
          "it is not in equilibrium where all coordinates are 0: no spring or tyre carries the weight "
          "along " +
          d_.coordinate[static_cast<std::size_t>(*balance.not_carried)].name);
    std::vector<Expression> tensions(all.size());
    for (Eigen::Index k = 0; k < n; ++k) {
      Expression& tension = tensions[static_cast<std::size_t>(k)];
      for (Eigen::Index i = 0; i < f; ++i)
        if (const double share = balance.tension_of_weight(k, i); share != 0.0)
          tension += share * weight_[static_cast<std::size_t>(i)];
      tension = tension.simplified();
    }
    return tensions;
  }

  /// F_z = Om^2 (uc cos a - us sin a), F_x = Om^2 (uc sin a + us cos a)   (conventions.md)
  void unbalances() {
    e_.up = e_.forward = ExpressionMatrix(f_, d_.unbalance.size());
    for (std::size_t n = 0; n < d_.unbalance.size(); ++n) {
      const UnbalanceDescription& plane = d_.unbalance[n];
      const ExpressionVector centre = point(plane.point);
      const ExpressionRow up = at_.slope(centre[2]), forward = at_.slope(centre[0]);
      const Expression cosine = names_(plane.cosine), sine = names_(plane.sine);
      const auto rotor = std::ranges::find(e_.rotor, plane.rotor) - e_.rotor.begin();
      const auto column = 2 * static_cast<std::size_t>(rotor);
      for (std::size_t i = 0; i < f_; ++i) {
        e_.up(i, n) = up[i];
        e_.forward(i, n) = forward[i];
        e_.T(i, column) += cosine * forward[i] - sine * up[i];
        e_.T(i, column + 1) += cosine * up[i] + sine * forward[i];
      }
    }
  }

  void sensors() {
    e_.acceleration = e_.tilt = ExpressionMatrix(d_.sensor.size(), f_);
    for (std::size_t n = 0; n < d_.sensor.size(); ++n) {
      const SensorDescription& sensor = d_.sensor[n];
      const int body = d_.point[static_cast<std::size_t>(sensor.point)].body;
      const ExpressionVector place = point(sensor.point),
                             direction = frame(body).rotation * names_(sensor.direction);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const ExpressionRow row = at_.slope(place[axis]);
        for (std::size_t i = 0; i < f_; ++i) e_.acceleration(n, i) += at_.at_rest(direction[axis]) * row[i];
      }
      const ExpressionRow tilted = at_.slope(direction[2]);
      for (std::size_t i = 0; i < f_; ++i) e_.tilt(n, i) = Expression(d_.gravity_m_s2) * tilted[i];
    }
  }

  void check_masses() const {
    const auto f = static_cast<Eigen::Index>(f_);
    const Eigen::MatrixXd mass = Eigen::MatrixXd::NullaryExpr(f, f, [this](Eigen::Index i, Eigen::Index j) {
      return number(e_.M(static_cast<std::size_t>(i), static_cast<std::size_t>(j)));
    });
    for (Eigen::Index i = 0; i < f; ++i)
      if (!(mass(i, i) > 0.0)) fail(d_.coordinate[static_cast<std::size_t>(i)].name + " moves no mass");
    if (Eigen::LLT<Eigen::MatrixXd>(mass).info() != Eigen::Success)
      fail("two coordinates move the same masses alike, or a mass is negative");
  }

  [[noreturn]] void fail(const std::string& reason) const { throw ConfigError(d_.name + ": " + reason); }

  const Description& d_;
  Names names_;
  std::vector<BodyFrame> frames_;
  std::size_t f_;
  Linearisation at_;
  std::vector<std::pair<Expression, Expression>> values_;
  ExpressionRow weight_;
  Equations e_;
};

}  // namespace

Equations derive(const Description& description) {
  try {
    return Derivation(description).all();
  } catch (const ConfigError&) {
    throw;
  } catch (const std::exception& error) {
    throw ConfigError(description.name + ": the equations cannot be derived: " + error.what());
  }
}

}  // namespace roadbalance

#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace roadbalance {

/// A symbolic expression in numbers and named symbols: + - * /, sin, cos, square root.
///
/// A value that does not change; copies are cheap.  Behind it is GiNaC, which is not made for threads: all
/// expressions of a process belong to one thread.  A result that cannot be computed (a division by zero)
/// throws std::exception.
class Expression {
 public:
  /// As exact as its shortest decimal: 0.1 is a tenth.
  Expression(double number = 0.0);  // NOLINT(google-explicit-constructor): a number is an expression
  /// A real number with a name; another one at each call, whatever its name.
  /// @param positive  it is known to be, so that sqrt(x x) is x
  static Expression symbol(const std::string& name, const std::string& latex, bool positive);

  Expression operator-() const;
  Expression& operator+=(const Expression& other);
  friend Expression operator+(const Expression& a, const Expression& b);
  friend Expression operator-(const Expression& a, const Expression& b);
  friend Expression operator*(const Expression& a, const Expression& b);
  friend Expression operator/(const Expression& a, const Expression& b);
  friend Expression sin(const Expression& a);
  friend Expression cos(const Expression& a);
  friend Expression sqrt(const Expression& a);

  /// @param symbol  made by symbol()
  Expression derivative(const Expression& symbol) const;
  bool contains(const Expression& symbol) const;
  /// With symbols replaced, all at once.
  Expression with(const std::vector<std::pair<Expression, Expression>>& replaced) const;
  /// Multiplied out, so that what cancels is gone.
  Expression simplified() const;
  /// True for the square root of a sum, which GiNaC leaves as it is.
  bool is_sum_below_root() const;
  /// True if it is written as 0; simplified() finds what else is 0.
  bool is_zero() const;
  bool is_number() const;
  /// @throws std::invalid_argument if symbols are left in it
  double number() const;

  /// The same text in every run: terms and factors are in alphabetical order.
  std::string cpp() const;
  std::string latex() const;

 private:
  struct Node;
  explicit Expression(std::shared_ptr<const Node> node);
  std::shared_ptr<const Node> node_;
};

}  // namespace roadbalance

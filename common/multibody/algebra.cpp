#include "common/multibody/algebra.hpp"

#include <ginac/ginac.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>

/// CLN keeps what it once allocated; a leak checker in the program is not to ask for it.
extern "C" {
const char* __lsan_default_suppressions() {
  return "leak:libcln.so";
}
const char* __lsan_default_options() {
  return "print_suppressions=0";
}
}

namespace roadbalance {
namespace {

/// The exact number that its shortest decimal writes, so that equal terms cancel.
GiNaC::ex from_double(double number) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, number, std::chars_format::scientific).ptr;
  const std::string decimal(text, end);
  const auto exponent = decimal.find('e');
  std::string digits = decimal.substr(0, exponent);
  int power = std::stoi(decimal.substr(exponent + 1));
  if (const auto point = digits.find('.'); point != std::string::npos) {
    power -= static_cast<int>(digits.size() - point - 1);
    digits.erase(point, 1);
  }
  return GiNaC::numeric(digits.c_str()) * GiNaC::pow(GiNaC::numeric(10), GiNaC::numeric(power));
}

/// An expression in both languages.  GiNaC's own order of terms changes from run to run.
struct Written {
  enum Level { kSum, kProduct, kAtom };
  std::string cpp, latex;
  Level level = kAtom;
  bool negative = false;  ///< what is written is to be subtracted
};

std::string in_parentheses(bool needed, const std::string& text) {
  return needed ? "(" + text + ")" : text;
}
std::string in_latex_parentheses(bool needed, const std::string& text) {
  return needed ? "\\left(" + text + "\\right)" : text;
}

Written write(const GiNaC::ex& e);

Written write_number(const GiNaC::numeric& number) {
  const double value = std::abs(number.to_double());
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  const std::string written(text, end);
  const auto exponent = written.find('e');
  Written result{written, written, Written::kAtom, number.is_negative()};
  if (exponent != std::string::npos)
    result.latex = written.substr(0, exponent) + "\\cdot 10^{" +
                   std::to_string(std::stoi(written.substr(exponent + 1))) + "}";
  return result;
}

std::vector<Written> operands(const GiNaC::ex& e) {
  std::vector<Written> parts;
  for (const auto& operand : e) parts.push_back(write(operand));
  std::ranges::stable_sort(parts, {}, &Written::cpp);
  return parts;
}

Written write_sum(const GiNaC::ex& e) {
  Written result{"", "", Written::kSum, false};
  for (const Written& part : operands(e)) {
    const bool first = result.cpp.empty();
    result.cpp += (first ? (part.negative ? "-" : "") : (part.negative ? " - " : " + ")) + part.cpp;
    result.latex += (first ? (part.negative ? "-" : "") : (part.negative ? " - " : " + ")) + part.latex;
  }
  return result;
}

Written write_power(const GiNaC::ex& base, const GiNaC::numeric& exponent) {
  const Written inner = write(base);
  const bool sum = inner.level != Written::kAtom;
  if (exponent == GiNaC::numeric(1, 2))
    return {"std::sqrt(" + inner.cpp + ")", "\\sqrt{" + inner.latex + "}", Written::kAtom, false};
  const Written power = write_number(exponent);
  Written result{"std::pow(" + inner.cpp + ", " + power.cpp + ")",
                 in_latex_parentheses(sum, inner.latex) + "^{" + power.latex + "}", Written::kAtom, false};
  if (exponent.is_integer() && exponent <= 4) {
    result.cpp.clear();
    for (int i = exponent.to_int(); i > 0; --i)
      result.cpp += in_parentheses(sum, inner.cpp) + (i > 1 ? "*" : "");
    result.level = Written::kProduct;
  }
  return result;
}

/// A product; factors with negative powers come below the line.
Written write_product(const GiNaC::ex& e) {
  std::vector<Written> above, below;
  Written number{"", "", Written::kAtom, false};
  bool negative = false;
  const auto take = [&](const GiNaC::ex& factor) {
    if (GiNaC::is_a<GiNaC::numeric>(factor)) {
      number = write(factor);
      negative = negative != number.negative;
      return;
    }
    const bool power = GiNaC::is_a<GiNaC::power>(factor) && GiNaC::is_a<GiNaC::numeric>(factor.op(1));
    const auto exponent = power ? GiNaC::ex_to<GiNaC::numeric>(factor.op(1)) : GiNaC::numeric(1);
    GiNaC::ex base = power ? factor.op(0) : factor;
    // GiNaC writes a - b or b - a as it happens: here its first term is to be positive.
    if (GiNaC::is_a<GiNaC::add>(base) && exponent.is_integer() && write_sum(base).cpp[0] == '-') {
      base = (-base).expand();
      negative = negative != exponent.is_odd();
    }
    const auto size = GiNaC::abs(exponent);
    (exponent.is_negative() ? below : above).push_back(size == 1 ? write(base) : write_power(base, size));
  };
  if (GiNaC::is_a<GiNaC::mul>(e))
    for (const auto& factor : e) take(factor);
  else
    take(e);
  Written result{number.cpp == "1" ? "" : number.cpp, number.latex == "1" ? "" : number.latex,
                 Written::kProduct, negative};
  const auto multiply = [](Written& product, std::vector<Written>& factors) {
    std::ranges::stable_sort(factors, {}, &Written::cpp);
    for (const Written& factor : factors) {
      const bool sum = factor.level == Written::kSum;
      product.cpp += (product.cpp.empty() ? "" : "*") + in_parentheses(sum, factor.cpp);
      product.latex += (product.latex.empty() ? "" : " ") + in_latex_parentheses(sum, factor.latex);
    }
    if (product.cpp.empty()) product.cpp = product.latex = "1";
  };
  multiply(result, above);
  if (below.empty()) return result;
  Written divisor{"", "", Written::kProduct, false};
  multiply(divisor, below);
  return {
      result.cpp + "/" + in_parentheses(below.size() > 1 || below[0].level != Written::kAtom, divisor.cpp),
      "\\frac{" + result.latex + "}{" + divisor.latex + "}", Written::kProduct, result.negative};
}

Written write(const GiNaC::ex& e) {
  if (GiNaC::is_a<GiNaC::numeric>(e)) return write_number(GiNaC::ex_to<GiNaC::numeric>(e));
  if (GiNaC::is_a<GiNaC::symbol>(e)) {
    const auto& symbol = GiNaC::ex_to<GiNaC::symbol>(e);
    return {symbol.get_name(), symbol.get_TeX_name(), Written::kAtom, false};
  }
  if (GiNaC::is_a<GiNaC::add>(e)) return write_sum(e);
  if (GiNaC::is_a<GiNaC::power>(e) && GiNaC::is_a<GiNaC::numeric>(e.op(1)) &&
      !GiNaC::ex_to<GiNaC::numeric>(e.op(1)).is_negative())
    return write_power(e.op(0), GiNaC::ex_to<GiNaC::numeric>(e.op(1)));
  if (GiNaC::is_a<GiNaC::function>(e)) {
    const std::string name = GiNaC::ex_to<GiNaC::function>(e).get_name();
    const Written argument = write(e.op(0));
    const std::string sign = argument.negative ? "-" : "";
    return {"std::" + name + "(" + sign + argument.cpp + ")",
            "\\" + name + "\\left(" + sign + argument.latex + "\\right)", Written::kAtom, false};
  }
  return write_product(e);
}

}  // namespace

struct Expression::Node {
  explicit Node(GiNaC::ex value) : ex(std::move(value)) {}
  GiNaC::ex ex;
};

Expression::Expression(std::shared_ptr<const Node> node) : node_(std::move(node)) {}
Expression::Expression(double number) : node_(std::make_shared<const Node>(from_double(number))) {}

Expression Expression::symbol(const std::string& name, const std::string& latex, bool positive) {
  if (positive) return Expression(std::make_shared<const Node>(GiNaC::possymbol(name, latex)));
  return Expression(std::make_shared<const Node>(GiNaC::realsymbol(name, latex)));
}

Expression Expression::operator-() const {
  return Expression(std::make_shared<const Node>(-node_->ex));
}
Expression operator+(const Expression& a, const Expression& b) {
  return Expression(std::make_shared<const Expression::Node>(a.node_->ex + b.node_->ex));
}
Expression operator-(const Expression& a, const Expression& b) {
  return Expression(std::make_shared<const Expression::Node>(a.node_->ex - b.node_->ex));
}
Expression operator*(const Expression& a, const Expression& b) {
  return Expression(std::make_shared<const Expression::Node>(a.node_->ex * b.node_->ex));
}
Expression operator/(const Expression& a, const Expression& b) {
  return Expression(std::make_shared<const Expression::Node>(a.node_->ex / b.node_->ex));
}
Expression& Expression::operator+=(const Expression& other) {
  return *this = *this + other;
}
Expression sin(const Expression& a) {
  return Expression(std::make_shared<const Expression::Node>(GiNaC::sin(a.node_->ex)));
}
Expression cos(const Expression& a) {
  return Expression(std::make_shared<const Expression::Node>(GiNaC::cos(a.node_->ex)));
}
Expression sqrt(const Expression& a) {
  return Expression(std::make_shared<const Expression::Node>(GiNaC::sqrt(a.node_->ex)));
}

Expression Expression::derivative(const Expression& symbol) const {
  return Expression(
      std::make_shared<const Node>(node_->ex.diff(GiNaC::ex_to<GiNaC::symbol>(symbol.node_->ex))));
}

bool Expression::contains(const Expression& symbol) const {
  return node_->ex.has(symbol.node_->ex);
}

Expression Expression::with(const std::vector<std::pair<Expression, Expression>>& replaced) const {
  GiNaC::exmap map;
  for (const auto& [symbol, by] : replaced) map.emplace(symbol.node_->ex, by.node_->ex);
  return Expression(std::make_shared<const Node>(node_->ex.subs(map, GiNaC::subs_options::no_pattern)));
}

Expression Expression::simplified() const {
  return Expression(std::make_shared<const Node>(node_->ex.expand()));
}

bool Expression::is_sum_below_root() const {
  const GiNaC::ex& e = node_->ex;
  return GiNaC::is_a<GiNaC::power>(e) && GiNaC::is_a<GiNaC::add>(e.op(0));
}

bool Expression::is_zero() const {
  return node_->ex.is_zero();
}

bool Expression::is_number() const {
  return GiNaC::is_a<GiNaC::numeric>(node_->ex.evalf());
}

double Expression::number() const {
  const GiNaC::ex value = node_->ex.evalf();
  if (!GiNaC::is_a<GiNaC::numeric>(value)) throw std::invalid_argument(cpp() + " is no number");
  return GiNaC::ex_to<GiNaC::numeric>(value).to_double();
}

std::string Expression::cpp() const {
  const Written written = write(node_->ex);
  return (written.negative ? "-" : "") + written.cpp;
}

std::string Expression::latex() const {
  const Written written = write(node_->ex);
  return (written.negative ? "-" : "") + written.latex;
}

}  // namespace roadbalance

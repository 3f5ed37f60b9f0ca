#pragma once

#include <cmath>
#include <string>
#include <vector>

namespace roadbalance {

/// A formula of a description: numbers, names, + - * /, parentheses, sin(...) and cos(...).
class Formula {
 public:
  enum class Kind { kNumber, kName, kPlus, kMinus, kTimes, kOver, kNegated, kSine, kCosine };
  struct Step {
    Kind kind;
    double number = 0.0;
    std::string name{};
  };

  Formula() : Formula("0") {}
  /// @throws std::invalid_argument saying what is wrong with it
  explicit Formula(const std::string& text);

  const std::string& text() const { return text_; }
  /// In postfix order: each operator comes behind its operands.
  const std::vector<Step>& steps() const { return steps_; }

  /// Its value; `Value` has + - * / and sin, cos and is made from a number.
  /// @param named  the value of a name
  template <typename Value, typename Named>
  Value value(const Named& named) const {
    using std::cos;
    using std::sin;
    std::vector<Value> stack;
    const auto take = [&stack] {
      Value last = stack.back();
      stack.pop_back();
      return last;
    };
    for (const Step& step : steps_) {
      if (step.kind == Kind::kNumber) {
        stack.push_back(Value(step.number));
      } else if (step.kind == Kind::kName) {
        stack.push_back(named(step.name));
      } else if (step.kind == Kind::kNegated) {
        stack.back() = -stack.back();
      } else if (step.kind == Kind::kSine) {
        stack.back() = sin(stack.back());
      } else if (step.kind == Kind::kCosine) {
        stack.back() = cos(stack.back());
      } else {
        const Value right = take(), left = take();
        stack.push_back(step.kind == Kind::kPlus    ? left + right
                        : step.kind == Kind::kMinus ? left - right
                        : step.kind == Kind::kTimes ? left * right
                                                    : left / right);
      }
    }
    return stack.back();
  }

 private:
  std::string text_;
  std::vector<Step> steps_;
};

/// True for a name that formulas and generated code can hold: lower-case letters, digits and _, a letter
/// first, at most 40 of them, no word of C++, and not as lengths and tensions
/// at rest are named (length_..., tension_...).
bool is_formula_name(const std::string& name);

}  // namespace roadbalance

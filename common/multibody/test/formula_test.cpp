#include "common/multibody/formula.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace roadbalance {
namespace {

double value(const std::string& text) {
  return Formula(text).value<double>([](const std::string& name) { return name == "a" ? 2.0 : 5.0; });
}

std::string refusal(const std::string& text) {
  try {
    const Formula formula(text);
    return "accepted";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(Formula, BindsAsWrittenMathematicsDoes) {
  EXPECT_EQ(value("1 + 2 * 3 - 4 / 8"), 6.5);
  EXPECT_EQ(value("(1 + 2) * 3"), 9.0);
  EXPECT_EQ(value("10 - 3 - 2"), 5.0);
  EXPECT_EQ(value("12 / 3 / 2"), 2.0);
  EXPECT_EQ(value("-a + b"), 3.0);
  EXPECT_EQ(value("2*-a"), -4.0);
  EXPECT_EQ(value("- - 3"), 3.0);
  EXPECT_EQ(value(" 1.5e2 "), 150.0);
  EXPECT_EQ(value("sin(a) + cos( a*b )"), std::sin(2.0) + std::cos(10.0));
  EXPECT_EQ(Formula().value<double>([](const std::string&) { return 1.0; }), 0.0);
}

TEST(Formula, SaysWhatIsWrong) {
  EXPECT_EQ(refusal("(1 + 2"), "is no formula: a ) is missing");
  EXPECT_EQ(refusal("sin 3"), "is no formula: a ( is missing behind sin");
  EXPECT_EQ(refusal("1 2"), "is no formula: there is something behind its end: 2");
  for (const char* text :
       {"", "1 +", "a b", "tan(a)", "1..2", "A", "*2", "1e999", "2e12", "a^2", "int", "_a"})
    EXPECT_NE(refusal(text).find("is no formula"), std::string::npos) << text;
  EXPECT_NE(refusal(std::string(301, '1')).find("is too long"), std::string::npos);
  EXPECT_NE(refusal(std::string(100, '(') + "1" + std::string(100, ')')).find("too deeply"),
            std::string::npos);
  EXPECT_NE(refusal(std::string(100, '-') + "1").find("too deeply"), std::string::npos);
}

TEST(Formula, NamesAreThoseOfGeneratedCodeToo) {
  for (const char* name : {"a", "spring_front_left", "x2"}) EXPECT_TRUE(is_formula_name(name)) << name;
  for (const char* name : {"", "2x", "_x", "X", "double", "sin", "geometry", "tension_spring_front", "x-y"})
    EXPECT_FALSE(is_formula_name(name)) << name;
  EXPECT_FALSE(is_formula_name(std::string(41, 'a')));
}

}  // namespace
}  // namespace roadbalance

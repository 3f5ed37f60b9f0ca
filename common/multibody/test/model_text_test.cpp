#include "common/multibody/model_text.hpp"

#include <gtest/gtest.h>

#include <random>

#include "common/multibody/shipped.hpp"
#include "common/multibody/test/reference.hpp"
#include "derived/half_car.hpp"
#include "derived/hub_axis.hpp"
#include "derived/quarter_car.hpp"
#include "derived/seven_dof.hpp"
#include "derived/swing_arm.hpp"

// The derived headers are what cpp_text() wrote when this test was built: that they compile is the first
// test.

namespace roadbalance {
namespace {

template <int Rows, int Columns>
Eigen::MatrixXd matrix(const double (&entries)[Rows][Columns]) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(entries[0], Rows, Columns);
}

/// Parameters within 50 % of the description's (of those that are 0: of 1), and its geometry.
template <typename Function>
void expect_same_numbers(const std::string& name, const Function& equations, bool has_damped_tyres = true) {
  const Description description = test::description(name);
  const AffineModel model = affine_model(derive(description));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> factor(0.5, 1.5);
  Eigen::VectorXd parameters = model.nominal;
  for (double& p : parameters) p = (p == 0.0 ? 1.0 : p) * factor(random);
  std::vector<double> geometry;
  for (const NamedValue& one : description.geometry) geometry.push_back(one.value);
  const auto e = equations(parameters.data(), geometry.data());
  const ModelMatrices m = model.at(parameters);
  const auto expect_near = [&](const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected,
                               const char* what) {
    EXPECT_LT((found - expected).norm(), 1e-12 * (1.0 + expected.norm())) << name << " " << what;
  };
  expect_near(matrix(e.M), m.M, "M");
  expect_near(matrix(e.P), m.P, "P");
  expect_near(matrix(e.Q), m.Q, "Q");
  expect_near(matrix(e.S), m.S, "S");
  expect_near(matrix(e.Sd), m.Sd, "Sd");
  expect_near(matrix(e.T), m.T, "T");
  expect_near(matrix(e.C), model.acceleration, "C");
  expect_near(matrix(e.G), model.tilt, "G");
  EXPECT_GT(m.Q.norm(), 0.0);
  EXPECT_EQ(m.Sd.norm() > 0.0, has_damped_tyres);
}

TEST(CppText, CompilesToTheNumbersOfTheAffineModel) {
  expect_same_numbers("quarter_car", quarter_car::equations);
  expect_same_numbers("half_car", half_car::equations);
  expect_same_numbers("seven_dof", seven_dof::equations);
  expect_same_numbers("hub_axis", hub_axis::equations, false);
  expect_same_numbers("swing_arm", swing_arm::equations);
}

TEST(CppText, HoldsForEveryGeometryWhereNoTensionOccurs) {
  const std::vector<std::pair<std::string, double>> moved{{"x_front_left", 1.1},
                                                          {"x_front_right", 1.2},
                                                          {"x_rear_left", -1.6},
                                                          {"y_front_left", 0.8},
                                                          {"y_rear_right", -0.6}};
  const Description description = test::with(test::description("seven_dof"), moved);
  const AffineModel model = affine_model(derive(description));
  std::vector<double> geometry;
  for (const NamedValue& one : description.geometry) geometry.push_back(one.value);
  const auto e = seven_dof::equations(model.nominal.data(), geometry.data());
  const ModelMatrices m = model.at(model.nominal);
  EXPECT_LT((matrix(e.Q) - m.Q).norm(), 1e-12 * m.Q.norm());
  EXPECT_LT((matrix(e.C) - model.acceleration).norm(), 1e-14);
}

TEST(CppText, NamesParametersInTheOrderOfTheFile) {
  const Description description = shipped_description("half_car");
  ASSERT_EQ(description.parameter.size(), static_cast<std::size_t>(half_car::kParameterCount));
  for (std::size_t k = 0; k < description.parameter.size(); ++k) {
    EXPECT_EQ(description.parameter[k].name, half_car::kParameterName[k]);
    EXPECT_EQ(description.parameter[k].value, half_car::kParameterValue[k]);
  }
  EXPECT_EQ(cpp_name("My car, 2nd"), "my_car__2nd");
  EXPECT_EQ(cpp_name("2CV"), "model_2cv");
}

TEST(Texts, AreTheSameInEveryDerivation) {
  for (const char* name : {"seven_dof", "swing_arm"}) {
    const Description description = test::description(name);
    EXPECT_EQ(cpp_text(derive(description)), cpp_text(derive(description))) << name;
    EXPECT_EQ(latex_text(derive(description)), latex_text(derive(description))) << name;
  }
}

TEST(LatexText, WritesTheQuarterCarAsAnyBookDoes) {
  const std::string text = latex_text(derive(shipped_description("quarter_car")));
  EXPECT_NE(text.find("M &= \\begin{bmatrix}\n  m_c & 0 \\\\\n  0 & m_w\n\\end{bmatrix} \\\\\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("P &= \\begin{bmatrix}\n  d_s & -d_s \\\\\n  -d_s & d_s + d_t\n\\end{bmatrix}"),
            std::string::npos);
  EXPECT_NE(text.find("Q &= \\begin{bmatrix}\n  c_s & -c_s \\\\\n  -c_s & c_s + c_t\n\\end{bmatrix}"),
            std::string::npos);
  EXPECT_NE(text.find("T / \\Omega^2 &= \\begin{bmatrix}\n  0 & 0 \\\\\n  -u_s & u_c\n\\end{bmatrix}"),
            std::string::npos);
}

TEST(LatexText, IsBalanced) {
  for (const char* name : {"quarter_car", "half_car", "seven_dof", "hub_axis", "swing_arm"}) {
    const std::string text = latex_text(derive(test::description(name)));
    const auto count = [&text](const std::string& what) {
      int times = 0;
      for (auto place = text.find(what); place != std::string::npos; place = text.find(what, place + 1))
        ++times;
      return times;
    };
    EXPECT_EQ(count("{"), count("}")) << name;
    EXPECT_EQ(count("\\left("), count("\\right)")) << name;
    EXPECT_EQ(count("\\begin{bmatrix}"), count("\\end{bmatrix}")) << name;
    EXPECT_EQ(count("\\\\\n\\end{align*}"), 0) << name;  // TeX would set an empty line
    EXPECT_EQ(count("inf") + count("nan"), 0) << name;
  }
}

}  // namespace
}  // namespace roadbalance

#include "common/multibody/equations.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/config/section.hpp"
#include "common/multibody/modes.hpp"
#include "common/multibody/shipped.hpp"
#include "common/multibody/test/reference.hpp"

namespace roadbalance {
namespace {

constexpr double kPi = std::numbers::pi;

AffineModel model_of(const Description& description) {
  return affine_model(derive(description));
}

ModelMatrices nominal(const Description& description) {
  const AffineModel model = model_of(description);
  return model.at(model.nominal);
}

std::string refusal(const std::string& text) {
  try {
    affine_model(derive(Description::parse(text, "car.toml")));
    return "accepted";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

TEST(Equations, OfTheQuarterCarAreTheTextbooks) {
  // m_c z_c'' + d (z_c' - z_w') + c (z_c - z_w) = 0,  m_w z_w'' - ... + c_t z_w + d_t z_w' = c_t u + d_t u' +
  // F
  const auto m =
      nominal(test::with(test::description("quarter_car"),
                         {{"tyre_damper", 120.0}, {"unbalance_cosine", 0.004}, {"unbalance_sine", 0.003}}));
  Eigen::Matrix2d M, P, Q, T;
  M << 325, 0, 0, 34;
  P << 1500, -1500, -1500, 1620;
  Q << 22'000, -22'000, -22'000, 237'000;
  T << 0, 0, -0.003, 0.004;
  EXPECT_EQ(m.M, M);
  EXPECT_EQ(m.P, P);
  EXPECT_EQ(m.Q, Q);
  EXPECT_EQ(m.T, T);
  EXPECT_EQ(m.S, Eigen::Vector2d(0, 215'000));
  EXPECT_EQ(m.Sd, Eigen::Vector2d(0, 120));
}

TEST(Modes, OfTheUndampedQuarterCarSolveItsQuadratic) {
  const auto m = nominal(test::with(test::description("quarter_car"), {{"damper", 0.0}}));
  // m_c m_w w^4 - (m_c (c + c_t) + m_w c) w^2 + c c_t = 0
  const double a = 325.0 * 34.0, b = 325.0 * 237'000.0 + 34.0 * 22'000.0, c = 22'000.0 * 215'000.0;
  const double root = std::sqrt(b * b - 4.0 * a * c);
  const auto found = modes(m);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].frequency_hz(), std::sqrt((b - root) / (2.0 * a)) / (2.0 * kPi), 1e-10);
  EXPECT_NEAR(found[1].frequency_hz(), std::sqrt((b + root) / (2.0 * a)) / (2.0 * kPi), 1e-10);
  EXPECT_NEAR(found[0].damping(), 0.0, 1e-10);
  // Wheel against body: (c - w^2 m_c) z_c = c z_w.
  const double w2 = (b + root) / (2.0 * a);
  EXPECT_NEAR(found[1].shape(0).real(), 22'000.0 / (22'000.0 - w2 * 325.0), 1e-10);
  // Divided by itself: exactly 1 only where no product is fused with a sum.
  EXPECT_LT(std::abs(found[1].shape(1) - 1.0), 1e-15);
}

TEST(Modes, ThatDoNotSwingAreKeptWithTheirDecay) {
  ModelMatrices m;
  m.M = Eigen::MatrixXd::Identity(1, 1);
  m.P = Eigen::MatrixXd::Constant(1, 1, 5.0);
  m.Q = Eigen::MatrixXd::Constant(1, 1, 4.0);  // s^2 + 5 s + 4 = (s + 1)(s + 4)
  const auto found = modes(m);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_FALSE(found[0].swings());
  EXPECT_NEAR(found[0].pole.real(), -1.0, 1e-12);
  EXPECT_NEAR(found[1].pole.real(), -4.0, 1e-12);
}

/// A rigid pendulum: mass m at a distance l below (or above) its joint, inertia I, a spring on the angle.
std::string pendulum(const std::string& z, const std::string& spring) {
  return "name = \"pendulum\"\ncoordinates = [\"angle\"]\n[parameter]\nm = 2\ni = 0.3\nc = " + spring +
         "\n[geometry]\nl = 0.5\n[[body]]\nname = \"joint\"\nposition = [0, 0, 3]\naxes = \"x\"\nangles = "
         "[\"angle\"]\n"
         "[[body]]\nname = \"bob\"\non = \"joint\"\nposition = [0, 0, \"" +
         z +
         "\"]\nmass = \"m\"\ninertia = [\"i\", 0, 0]\n"
         "[[spring]]\nname = \"spring\"\nstretch = \"angle\"\nstiffness = \"c\"\n";
}

TEST(Equations, GravityIsTheStiffnessOfAPendulum) {
  const auto hangs = nominal(Description::parse(pendulum("-l", "0"), "pendulum"));
  EXPECT_NEAR(hangs.M(0, 0), 0.3 + 2.0 * 0.25, 1e-15);
  EXPECT_NEAR(hangs.Q(0, 0), 2.0 * 9.81 * 0.5, 1e-14);
  const auto stands = nominal(Description::parse(pendulum("l", "30"), "pendulum"));
  EXPECT_NEAR(stands.Q(0, 0), 30.0 - 2.0 * 9.81 * 0.5, 1e-13);
}

/// A mass that hangs on a spring of length l swings sideways as a pendulum of that length: the tension m g
/// over l.
TEST(Equations, TheTensionOfASpringHoldsSideways) {
  const auto m = nominal(Description::parse(R"(
name = "string"
coordinates = ["side", "up"]
[parameter]
m = 2
c = 1000
[geometry]
l = 0.7
[[body]]
name = "bob"
position = ["side", 0, "up - l"]
mass = "m"
[[point]]
name = "nail"
position = [0, 0, 0]
[[point]]
name = "bob"
body = "bob"
position = [0, 0, 0]
[[spring]]
name = "string"
between = ["nail", "bob"]
stiffness = "c"
)",
                                            "string"));
  EXPECT_NEAR(m.Q(0, 0), 2.0 * 9.81 / 0.7, 1e-9);  // tensions are rounded at 1e-12
  EXPECT_NEAR(m.Q(1, 1), 1000.0, 1e-9);
  EXPECT_EQ(m.Q(0, 1), 0.0);
}

/// The car of R. N. Jazar, Vehicle Dynamics, example 508, without stabiliser.  Its wheels are numbered round
/// the car, so that b1 = 0.7 m is at the front left and the rear right, b2 = 0.75 m at the others.  The
/// frequencies were computed elsewhere from these numbers, to three decimals.
TEST(Modes, OfJazarsCarAreThoseComputedElsewhere) {
  std::vector<std::pair<std::string, double>> values{{"body_mass", 840},
                                                     {"roll_inertia", 820},
                                                     {"pitch_inertia", 1100},
                                                     {"stabiliser_front", 0},
                                                     {"stabiliser_rear", 0}};
  for (const std::string wheel : {"front_left", "front_right", "rear_left", "rear_right"}) {
    const bool front = wheel.starts_with("front"), left = wheel.ends_with("left");
    const double side_m = front == left ? 0.7 : 0.75;
    values.insert(values.end(), {{"wheel_mass_" + wheel, front ? 53 : 76},
                                 {"spring_" + wheel, front ? 10'000 : 13'000},
                                 {"damper_" + wheel, 0},
                                 {"tyre_" + wheel, 200'000},
                                 {"x_" + wheel, front ? 1.4 : -1.47},
                                 {"y_" + wheel, left ? side_m : -side_m}});
  }
  const auto found = modes(nominal(test::with(test::description("seven_dof"), values)));
  const double expected_hz[] = {0.840, 1.113, 1.464, 8.427, 8.433, 10.019, 10.022};
  ASSERT_EQ(found.size(), 7U);
  for (std::size_t k = 0; k < 7; ++k) EXPECT_NEAR(found[k].frequency_hz(), expected_hz[k], 6e-4);
}

class SympyTest : public testing::TestWithParam<const char*> {};

TEST_P(SympyTest, FindsTheSameMatricesForEveryParameter) {
  const auto all = nlohmann::json::parse(test::read_source("common/multibody/test/data/sympy_matrices.json"));
  const nlohmann::json& sympy = all[GetParam()];
  const AffineModel model = model_of(test::description(GetParam()));
  const auto expect_equal = [&](const Eigen::MatrixXd& found, const std::string& matrix,
                                const std::string& parameter) {
    const Eigen::MatrixXd expected = test::sympy_matrix(sympy[matrix], parameter, found.rows(), found.cols());
    // Entries are of size 1; a tension is rounded at 1e-12 of a weight, which is 9.81 per kg.
    if (found.size() == 0) return;
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-11) << matrix << " " << parameter << "\n"
                                                               << found << "\nexpected\n"
                                                               << expected;
  };
  const auto expect_all = [&](const ModelMatrices& m, const std::string& parameter) {
    expect_equal(m.M, "M", parameter);
    expect_equal(m.P, "P", parameter);
    expect_equal(m.Q, "Q", parameter);
    expect_equal(m.S, "S", parameter);
    expect_equal(m.Sd, "Sd", parameter);
    expect_equal(m.T, "T", parameter);
  };
  expect_all(model.constant, "1");
  for (std::size_t p = 0; p < model.parameter.size(); ++p) {
    expect_all(model.of[p], model.parameter[p]);
    const ModelMatrices& of = model.of[p];
    EXPECT_GT(of.M.norm() + of.P.norm() + of.Q.norm() + of.T.norm(), 0.0) << model.parameter[p];
  }
  expect_equal(model.acceleration, "C", "1");
  expect_equal(model.tilt, "G", "1");
}

INSTANTIATE_TEST_SUITE_P(Descriptions, SympyTest,
                         testing::Values("half_car", "seven_dof", "hub_axis", "swing_arm"));

TEST(AffineModel, IsTheSameWhicheverParametersAreChosen) {
  const Equations equations = derive(test::description("swing_arm"));
  const AffineModel all = affine_model(equations),
                    two = affine_model(equations, {"rear_spring", "body_mass"});
  ASSERT_EQ(two.of.size(), 2U);
  EXPECT_EQ(two.nominal, Eigen::Vector2d(23'000, 650));
  const auto at = [&](double spring, double mass) {
    Eigen::VectorXd p = all.nominal;
    for (std::size_t k = 0; k < all.parameter.size(); ++k) {
      if (all.parameter[k] == "rear_spring") p(static_cast<Eigen::Index>(k)) = spring;
      if (all.parameter[k] == "body_mass") p(static_cast<Eigen::Index>(k)) = mass;
    }
    return all.at(p);
  };
  for (const auto& [spring, mass] : {std::pair{23'000.0, 650.0}, {26'000.0, 500.0}}) {
    const ModelMatrices a = at(spring, mass), b = two.at(Eigen::Vector2d(spring, mass));
    EXPECT_LT((a.Q - b.Q).norm(), 1e-9 * a.Q.norm());  // rounding
    EXPECT_LT((a.M - b.M).norm(), 1e-12 * a.M.norm());
    EXPECT_LT((a.P - b.P).norm(), 1e-12 * a.P.norm());
  }
  EXPECT_THROW(affine_model(equations, {"drop"}), ConfigError);
}

TEST(Equations, SayWhatCannotBe) {
  std::string text = pendulum("-l", "0");
  const auto swap = [&text](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    return refusal(changed);
  };
  EXPECT_EQ(swap("stiffness = \"c\"", "stiffness = \"c * c\""),
            "pendulum: the equations are not affine in c: 4.905*m + c*c");
  EXPECT_EQ(swap("stiffness = \"c\"", "stiffness = \"1 / (l - l)\""),
            "pendulum: the equations cannot be derived: power::eval(): division by zero");
  EXPECT_EQ(swap("mass = \"m\"\ninertia = [\"i\", 0, 0]", ""), "pendulum: angle moves no mass");
  EXPECT_EQ(swap("position = [0, 0, \"-l\"]", "position = [0, \"l\", 0]"),
            "accepted");  // the spring holds it
  const auto spring = text.find("[[spring]]");
  text = text.substr(0, spring);
  EXPECT_EQ(swap("position = [0, 0, \"-l\"]", "position = [0, \"l\", 0]"),
            "pendulum: it is not in equilibrium where all coordinates are 0: no spring or tyre carries the "
            "weight along angle");
}

}  // namespace
}  // namespace roadbalance

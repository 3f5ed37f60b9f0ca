#include "common/multibody/description.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/config/section.hpp"
#include "common/multibody/shipped.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

std::string quarter_car() {
  return test::read_source("common/multibody/descriptions/quarter_car.toml");
}

/// The error for the quarter car with the first `from` replaced by `to`; its line is that of `at` then.
void expect_refused(const std::string& from, const std::string& to, const std::string& at,
                    const std::string& said) {
  std::string text = quarter_car();
  const auto place = text.find(from);
  ASSERT_NE(place, std::string::npos) << from;
  text.replace(place, from.size(), to);
  const auto found = text.find(at);
  ASSERT_NE(found, std::string::npos) << at;
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(found + at.rfind('\n') + 1);
  const auto line = 1 + std::count(text.begin(), end, '\n');
  try {
    Description::parse(text, "car.toml");
    FAIL() << "accepted: " << to;
  } catch (const ConfigError& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, 200), "car.toml:" + std::to_string(line) + ": " + said);
  }
}

TEST(Description, ReadsTheQuarterCar) {
  const Description d = Description::parse(quarter_car(), "car.toml");
  EXPECT_EQ(d.name, "quarter car");
  EXPECT_EQ(d.gravity_m_s2, 9.81);
  ASSERT_EQ(d.coordinate.size(), 2U);
  EXPECT_EQ(d.coordinate[1].latex, "z_w");
  ASSERT_EQ(d.parameter.size(), 8U);
  EXPECT_EQ(d.parameter[0].name, "body_mass");  // in the order of the file
  EXPECT_EQ(d.parameter[4].name, "tyre");
  EXPECT_EQ(d.parameter[4].value, 215'000.0);
  EXPECT_EQ(d.geometry[0].latex, "\\mathrm{strut\\_length}");
  EXPECT_EQ(d.body[0].position[2].text(), "strut_length + body");
  EXPECT_EQ(d.spring[0].stretch.point, (std::array{0, 1}));
  EXPECT_EQ(d.rotors(), std::vector<std::string>{"wheel"});
}

TEST(Description, ALongNameMayBeLongerInLatex) {
  const std::string name = "a" + std::string(39, '_');
  const std::string given = quarter_car();
  const auto latex = given.find("[latex]");
  std::string without = given;
  without.erase(latex, given.find("\n[", latex) + 1 - latex);
  for (std::string text : {given, without}) {
    text.replace(text.find("[parameter]"), 11, "[parameter]\n" + name + " = 1");
    const Description d = Description::parse(text, "car.toml");
    EXPECT_EQ(d.parameter[0].name, name);
    EXPECT_GT(d.parameter[0].latex.size(), 60U);
  }
}

TEST(Description, ThoseThatShipAreSound) {
  EXPECT_EQ(shipped_descriptions(), (std::vector<std::string>{"quarter_car", "half_car", "seven_dof"}));
  for (const std::string& name : shipped_descriptions()) EXPECT_FALSE(shipped_description(name).tyre.empty());
  EXPECT_THROW(shipped_description("tricycle"), ConfigError);
}

TEST(Description, NamesFileLineAndKey) {
  expect_refused(
      "stiffness = \"tyre\"", "stiffnes = 3", "stiffnes = 3",
      "stiffnes: unknown key (did you mean stiffness?); allowed: a formula in quotes, or a number");
  expect_refused("stiffness = \"tyre\"", "", "[[tyre]]",
                 "stiffness: missing; allowed: a formula in quotes, or a number");
  expect_refused("direction = [0, 0, 1]", "direction = [0, 0, 1]\ncolour = 1", "colour",
                 "colour: unknown key; allowed here: name, point, direction");
  expect_refused("damping = \"damper\"", "damping = \"dampr\"", "damping = \"dampr\"",
                 "damping: nothing is named dampr");
  expect_refused(
      "damping = \"damper\"", "damping = \"2 ** 3\"", "damping = \"2",
      "damping: \"2 ** 3\" is no formula: a number or a name is missing at its end or before \"* 3\"");
  expect_refused("stiffness = \"spring\"", "stiffness = \"wheel\"", "stiffness = \"wheel\"",
                 "stiffness: wheel is a coordinate; allowed: parameters and geometry");
  expect_refused("between = [\"strut_top\", \"wheel_centre\"]", "between = [\"strut_top\", \"hub\"]",
                 "between = [\"strut_top\", \"hub\"]",
                 "between: there is no \"hub\"; allowed: strut_top, wheel_centre");
  expect_refused("between = [\"strut_top\", \"wheel_centre\"]", "between = [\"strut_top\"]",
                 "between = [\"strut_top\"]", "between: allowed: two names in [ ]");
  expect_refused("spring = 22000", "int = 22000", "int = 22000",
                 "int: \"int\" cannot be a name; allowed: lower-case letters, digits and _, a letter first, "
                 "at most 40, no word of C++");
  expect_refused("strut_length = 0.6", "body = 0.6", "body = 0.6", "body: \"body\" stands twice");
  expect_refused("spring = 22000", "spring = \"soft\"", "spring = \"soft\"",
                 "spring: is 'soft'; allowed: a number");
  expect_refused("mass = \"wheel_mass\"", "mass = \"wheel_mass\"\naxes = \"yw\"", "axes",
                 "axes: allowed: up to six of the letters x, y, z");
  expect_refused("mass = \"wheel_mass\"", "mass = \"wheel_mass\"\naxes = \"yx\"\nangles = [0.1]", "angles",
                 "angles: allowed: 2 formulas in quotes, or numbers, in [ ]");
  expect_refused("position = [0, 0, \"wheel\"]", "position = [0, 0]", "position = [0, 0]",
                 "position: allowed: 3 formulas in quotes, or numbers, in [ ]");
  expect_refused("moment = [\"unbalance_cosine\", \"unbalance_sine\"]", "moment = [true, 0]",
                 "moment = [true", "moment: is true; allowed: 2 formulas in quotes, or numbers, in [ ]");
  expect_refused("coordinates = [\"body\", \"wheel\"]", "coordinates = []", "coordinates",
                 "coordinates: is empty; allowed: 1 .. 16 names in [ ]");
}

TEST(Description, ABodyIsOnOneBeforeIt) {
  expect_refused("name = \"body\"\nposition", "name = \"body\"\non = \"wheel\"\nposition", "on = \"wheel\"",
                 "on: there is no \"wheel\"; allowed: none yet");
}

}  // namespace
}  // namespace roadbalance

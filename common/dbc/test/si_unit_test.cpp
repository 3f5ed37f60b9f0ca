#include "common/dbc/si_unit.hpp"

#include <numbers>
#include <string>

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(SiUnit, ConvertsWhatCarsReport) {
  constexpr double kPi = std::numbers::pi;
  EXPECT_DOUBLE_EQ(90 * si_unit("km/h").value().factor, 25.0);
  EXPECT_DOUBLE_EQ(90 * si_unit("kph").value().factor, 25.0);
  EXPECT_DOUBLE_EQ(100 * si_unit("mph").value().factor, 44.704);
  EXPECT_EQ(si_unit("m/s").value().factor, 1.0);
  EXPECT_DOUBLE_EQ(180 * si_unit("deg").value().factor, kPi);
  EXPECT_DOUBLE_EQ(180 * si_unit("\xB0").value().factor, kPi);
  EXPECT_DOUBLE_EQ(180 * si_unit("\xC2\xB0/s").value().factor, kPi);
  EXPECT_DOUBLE_EQ(60 * si_unit("rpm").value().factor, 2 * kPi);
  EXPECT_DOUBLE_EQ(60 * si_unit("1/min").value().factor, 2 * kPi);
  EXPECT_EQ(si_unit("").value().factor, 1.0);
  EXPECT_EQ(std::string(si_unit("mph").value().name), "m/s");
  EXPECT_EQ(std::string(si_unit("rpm").value().name), "rad/s");
}

TEST(SiUnit, DoesNotGuess) {
  for (const char* unit : {"furlong", "KM/H", " km/h", "km", "%", "V", "g"})
    EXPECT_FALSE(si_unit(unit)) << unit;
}

}  // namespace
}  // namespace roadbalance

#include "common/config/set_value.hpp"

#include <gtest/gtest.h>

#include <string>

#include "common/config/vehicle_config.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

const TablePath kEncoder{{"wheel", "right"}, {"encoder"}};

std::string set(const std::string& text, const TablePath& path, const std::string& key = "datum_deg",
                const std::string& value = "12.5") {
  return with_value(text, path, key, value, "car.toml");
}

std::string refusal(const std::string& text, const TablePath& path, const std::string& key = "datum_deg",
                    const std::string& value = "12.5") {
  try {
    return "accepted: " + set(text, path, key, value);
  } catch (const ConfigError& error) {
    return error.what();
  }
}

/// `text` has one "@" where something is changed, from the first string to the second.
void expect_changed(std::string text, const std::string& from, const std::string& to,
                    const TablePath& path = kEncoder) {
  std::string expected = text;
  expected.replace(expected.find('@'), 1, to);
  text.replace(text.find('@'), 1, from);
  EXPECT_EQ(set(text, path), expected);
}

TEST(WithValue, ReplacesTheValueOfTheTableThatIsMeantAndNoOtherByte) {
  expect_changed(
      "# \xC3\xA9t\xC3\xA9: datum_deg = 1\n[[wheel]]\nname = \"left\"\n[wheel.encoder]\ndatum_deg = 3 # "
      "left\n"
      "\n[[wheel]]\n\tname = 'right'   # \"left\"\n[ wheel . encoder ] # x\n\"\xC3\xA9\" = 1\n"
      "datum_deg   =\t@ # by hand\npulses = 96",
      "-3.25e1", "12.5");
  expect_changed("[[wheel]]\nname='right'\n[wheel.encoder]\r\ndatum_deg = @\r\nx = 1\r\n", "30", "12.5");
  expect_changed("[[wheel]]\nname='right'\nencoder = { \"\xC3\xA9\"='\xC3\xA9', datum_deg = @ } # }\n", "30",
                 "12.5");
  expect_changed("[[wheel]]\nname='right'\n[wheel.encoder]\ndatum_deg = @", "30", "12.5");
  expect_changed("x = 1\ndatum_deg = @\n[a]\n", "30", "12.5", {});
}

TEST(WithValue, AddsALineBehindTheTablesLast) {
  expect_changed(
      "[[wheel]]\nname = \"right\"\n[wheel.encoder]\n    pulses = 96 # datum_deg = 5\n@\n# of the other\n"
      "[[wheel]]\nname = \"left\"\n[wheel.encoder]\ndatum_deg = 4\n",
      "", "    datum_deg = 12.5\n");
  expect_changed("[[wheel]]\nname = \"right\"\n[wheel.encoder]  # none yet\n@[other]\nx = 1\n", "",
                 "datum_deg = 12.5\n");
  expect_changed("[[wheel]]\r\nname = \"right\"\r\n[wheel.encoder]\r\nx = 1\r\n@[other]\r\n", "",
                 "datum_deg = 12.5\r\n");
  expect_changed("[[wheel]]\nname = \"right\"\n[wheel.encoder]\nx = [1,\n  2]@", "", "\ndatum_deg = 12.5\n");
  // Before a table of its own: behind that the line would be the other's.
  expect_changed("[[wheel]]\nname = \"right\"\n@[wheel.encoder]\nx = 1\n", "", "datum_deg = 12.5\n",
                 {{"wheel", "right"}});
  expect_changed("@[a]\nx = 1\n", "", "datum_deg = 12.5\n", {});
}

TEST(WithValue, AddsToTheBracesOfAnInlineTable) {
  expect_changed("[[wheel]]\nname='right'\nencoder = { a = [1, 2], b = { c = '}' }@ }\n", "",
                 ", datum_deg = 12.5");
  expect_changed("[[wheel]]\nname='right'\nencoder = @ # none\n", "{}", "{ datum_deg = 12.5 }");
  expect_changed("wheel = [ { name = 'right', encoder = { a = 1@ } }, { name = 'left' } ]\n", "",
                 ", datum_deg = 12.5");
}

TEST(WithValue, MakesTheLastTableOfThePath) {
  expect_changed("[[wheel]]\nname = 'right'\nx = 1\n@[[wheel]]\nname = 'left'\n", "",
                 "encoder = { datum_deg = 12.5 }\n");
  EXPECT_EQ(set(set("[a]\nx = 1\n", {{"a"}, {"b"}}, "c", "1"), {{"a"}, {"b"}}, "d", "\"two\""),
            "[a]\nx = 1\nb = { c = 1, d = \"two\" }\n");
}

TEST(WithValue, RefusesWhatIsNotThereOrCannotBePlaced) {
  EXPECT_EQ(refusal("[[wheel]]\nname = 'left'\n", kEncoder),
            "car.toml: wheel \"right\".encoder: datum_deg: there is no table wheel \"right\" to set it in");
  EXPECT_NE(refusal("wheel = 3\n", kEncoder).find("there is no table wheel \"right\""), std::string::npos);
  EXPECT_NE(refusal("encoder = 3\n", {{"encoder"}}).find("there is no table encoder"), std::string::npos);
  EXPECT_NE(refusal("datum_deg = [1]\n", {}).find("is no single value"), std::string::npos);
  // A line more would belong to the wheel, not to its dotted table.
  EXPECT_NE(refusal("[[wheel]]\nname = 'right'\nencoder.x = 1\n", kEncoder).find("set it to 12.5 by hand"),
            std::string::npos);
  // A table that is named by its inner table's header only has no place of its own.
  EXPECT_NE(refusal("[a.b]\nx = 1\n", {{"a"}}).find("by hand"), std::string::npos);
  EXPECT_NE(refusal("[a\n", {{"a"}}).find("car.toml:1: not TOML"), std::string::npos);
  EXPECT_NE(refusal("[a]\n", {{"a"}}, "key", "1\nb = 2").find("by hand"), std::string::npos);
}

TEST(WithValue, SetsEveryWheelAndChannelOfTheDemonstrationCar) {
  const std::string text = test::read_source("sim/demo/vehicle.toml");
  const VehicleConfig before = VehicleConfig::parse(text, "car.toml");
  std::string changed = text;
  for (const WheelConfig& wheel : before.wheel) {
    changed = set(changed, {{"wheel", wheel.name}, {"encoder"}});
    changed = set(changed, {{"wheel", wheel.name}, {"encoder"}}, "datum_sigma_deg", "0.5");
  }
  for (const NodeConfig& node : before.node)
    for (const ChannelConfig& channel : node.channel) {
      const TablePath calibration{{"node", node.name}, {"channel", channel.name}, {"calibration"}};
      changed = set(changed, calibration, "scale_m_s2_per_count", "1e-5");
      changed = set(changed, calibration, "delay_us", "-7.5");
    }
  const VehicleConfig after = VehicleConfig::parse(changed, "car.toml");
  for (const WheelConfig& wheel : after.wheel) {
    EXPECT_NEAR(wheel.encoder.datum_rad, 12.5 * std::numbers::pi / 180.0, 1e-12);
    EXPECT_NEAR(wheel.encoder.datum_sigma_rad, 0.5 * std::numbers::pi / 180.0, 1e-12);
  }
  for (const NodeConfig& node : after.node)
    for (const ChannelConfig& channel : node.channel) {
      EXPECT_EQ(channel.scale_m_s2_per_count, 1e-5);
      EXPECT_NEAR(channel.delay_s, -7.5e-6, 1e-18);
    }
  // Four lines and twenty-four channels' more; nothing else.
  EXPECT_EQ(std::count(changed.begin(), changed.end(), '\n'),
            std::count(text.begin(), text.end(), '\n') + 4 + 24);
}

TEST(TomlNumber, SaysNoMoreDigitsThanItMust) {
  EXPECT_EQ(toml_number(12.5, 2), "12.5");
  EXPECT_EQ(toml_number(30.0, 2), "30");
  EXPECT_EQ(toml_number(-0.001, 2), "0");
  EXPECT_EQ(toml_number(-123.456, 2), "-123.46");
  EXPECT_EQ(toml_number(1200.0, 0), "1200");
}

}  // namespace
}  // namespace roadbalance

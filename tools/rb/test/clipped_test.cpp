// A drive whose sensors are clipped below the range that vehicle.toml gives them.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/test/run_rb.hpp"
#include "tools/rb/test/simulated_drives.hpp"

namespace roadbalance {
namespace {

using Names = std::set<std::string>;
/// On this road they see 25 m/s^2 and more in a minute; of the 200 m/s^2 that vehicle.toml has 12 are left,
/// of the 50 of the sensors on the body 3: more than those see.
const Names kCarriers{"fl_carrier_z", "fr_carrier_z", "rl_carrier_z", "rr_carrier_z"};

class Clipped : public testing::Test {
 protected:
  test::Outcome rb(const std::vector<std::string>& arguments) {
    return test::run_rb(arguments, folder_ / "rb.log");
  }
  /// 60 s of the demo car at 110 km/h.
  void drive(const std::string& clips_at) {
    const std::string demo = test::read_source("sim/demo/scenario.toml");
    std::ofstream(folder_ / "scenario.toml")
        << "[drive]\n[[drive.plateau]]\nspeed_km_h = 110\nseconds = 60\n"
        << test::replaced(demo.substr(demo.find("[road]")), "[sensor]", "[sensor]\nclips_at = " + clips_at);
    const std::string toml = test::read_source("sim/demo/vehicle.toml");
    std::ofstream(folder_ / "vehicle.toml") << toml;
    test::record_scenario(record_, VehicleConfig::parse(toml, "vehicle.toml"),
                          folder_ / "scenario.toml" + "?seed=2");
  }
  Names clipped_by_levels() {
    Names names;
    const auto found = rb({"levels", record_, "--json"});
    const auto levels = nlohmann::json::parse(found.output);
    for (const auto& channel : levels.at("channels"))
      if (channel.at("clipped_s") > 0.0) names.insert(channel.at("channel").get<std::string>());
    return names;
  }
  test::Outcome import_again() {
    EXPECT_EQ(rb({"export", record_, "--format", "csv", "-o", folder_ / "samples.csv", "--pulses",
                  folder_ / "pulses.csv"})
                  .code,
              0);
    return rb({"import", "csv", "--samples", folder_ / "samples.csv", "--pulses", folder_ / "pulses.csv",
               "--vehicle", folder_ / "vehicle.toml", "-o", folder_ / "imported"});
  }

  const test::TemporaryDirectory folder_;
  const std::string record_ = folder_ / "record";
};

TEST_F(Clipped, ChannelsAreNamedByEveryCommandAndTheirSectionsNotUsed) {
  drive("0.06");
  const Names clipped = clipped_by_levels();
  for (const std::string& carrier : kCarriers) EXPECT_TRUE(clipped.contains(carrier)) << carrier;
  for (const std::string& name : clipped) EXPECT_EQ(name.find("strut"), std::string::npos) << name;
  const auto levels = rb({"levels", record_});
  EXPECT_NE(levels.output.find("   CLIPPED "), std::string::npos) << levels.output;

  const auto identified = rb({"identify", record_});
  for (const std::string& carrier : kCarriers)
    EXPECT_NE(identified.log.find(carrier + " is clipped at "), std::string::npos) << identified.log;
  EXPECT_NE(identified.log.find("though its range is 200 m/s²"), std::string::npos) << identified.log;
  EXPECT_NE(identified.output.find("front left:  not known"), std::string::npos) << identified.output;

  const auto imported = import_again();
  for (const std::string& carrier : kCarriers)
    EXPECT_NE(imported.log.find("suspicious: " + carrier + " is clipped at "), std::string::npos)
        << imported.log;
}

TEST_F(Clipped, NoneIsNamedWhereNoneIs) {
  drive("1.0");
  EXPECT_EQ(clipped_by_levels(), Names{});
  EXPECT_EQ(rb({"levels", record_}).output.find("CLIPPED"), std::string::npos);
  EXPECT_EQ(rb({"identify", record_}).log.find("clipped"), std::string::npos);
  EXPECT_EQ(import_again().log.find("clipped"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance

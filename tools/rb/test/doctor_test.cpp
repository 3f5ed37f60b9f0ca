// rb doctor on what a user has: a folder, a vehicle.toml, a bus.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

class Doctor : public testing::Test {
 protected:
  test::Outcome doctor(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(),
                     {"doctor", "--folder", folder_.path(), "--seconds", "0.1", "--messages", "100"});
    return test::run_rb(arguments, folder_ / "rb.log");
  }
  /// The demonstration's vehicle with another front end of its first node.
  std::string vehicle(const std::string& front_end) const {
    std::string text = test::read_source("sim/demo/vehicle.toml");
    const std::string before = "name = \"front\"\n";
    const auto at = text.find(before);
    EXPECT_NE(at, std::string::npos);
    text.insert(at + before.size(), "front_end = " + front_end + "\n");
    const auto file = folder_ / "vehicle.toml";
    std::ofstream(file) << text;
    return file;
  }
  static Json finding(const Json& all, const std::string& name) {
    for (const Json& one : all["findings"])
      if (one["name"] == name) return one;
    return {};
  }
  test::TemporaryDirectory folder_;
};

TEST_F(Doctor, ProvesTheBusByALoopOfMessages) {
  const auto [code, output, log] = doctor({"--json"});
  const Json said = Json::parse(output);
  const Json loop = finding(said, "loopback");
  EXPECT_FALSE(loop["needed"].get<bool>()) << output;
  EXPECT_NE(loop["finding"].get<std::string>().find(" 100 came, after "), std::string::npos) << loop;
  EXPECT_TRUE(finding(said, "disk").is_object()) << output;
  EXPECT_TRUE(finding(said, "clock").is_object()) << output;
  EXPECT_TRUE(finding(said, "nodes").is_null()) << "on a bus of its own";
}

TEST_F(Doctor, OpensTheDevicesOfANode) {
  const auto well = doctor({"--json", "--vehicle", vehicle("[\"sim:?seed=1\"]"), "--node", "front"});
  EXPECT_TRUE(finding(Json::parse(well.output), "sim:?seed=1")["ok"].get<bool>()) << well.output;

  const auto ill =
      doctor({"--json", "--vehicle", vehicle("[\"can:nobody0\", \"gpio:gpiochip9999\", \"usb:1209:0001\"]"),
              "--node", "front"});
  EXPECT_EQ(ill.code, 1);
  const Json said = Json::parse(ill.output);
  for (const char* device : {"can:nobody0", "gpio:gpiochip9999", "usb:1209:0001"}) {
    const Json one = finding(said, device);
    ASSERT_TRUE(one.is_object()) << device << ": " << ill.output;
    EXPECT_TRUE(one["needed"].get<bool>()) << one;
    EXPECT_NE(one["finding"].get<std::string>().find("node front: "), std::string::npos) << one;
  }
}

TEST_F(Doctor, NamesWhatIsWrongWithTheQuestion) {
  EXPECT_EQ(doctor({"--vehicle", vehicle("\"sim:\""), "--node", "middle"}).code, 2);
  EXPECT_EQ(doctor({"--node", "front"}).code, 2);
  EXPECT_EQ(doctor({"--answer"}).code, 2);
  EXPECT_EQ(doctor({"--messages", "0"}).code, 2);
  const auto none = doctor({"--json", "--url", "udpm://nowhere"});
  EXPECT_EQ(none.code, 1);
  EXPECT_NE(none.output.find("LCM does not start"), std::string::npos) << none.output;
}

}  // namespace
}  // namespace roadbalance

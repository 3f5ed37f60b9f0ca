// rb doctor on what a user has: a folder, a vehicle.toml, a bus.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/test/bus_url.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

class Doctor : public testing::Test {
 protected:
  Doctor() { ::unsetenv(kBusUrlVariable); }
  ~Doctor() override { ::unsetenv(kBusUrlVariable); }
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
  for (const char* name : {"receive_buffer", "disk", "clock", "realtime", "memory"})
    EXPECT_TRUE(finding(said, name).is_object()) << name << ": " << output;
  EXPECT_TRUE(finding(said, "nodes").is_null()) << "on a bus of its own";
}

TEST_F(Doctor, LooksAtTheBusThatTheComputerIsSetTo) {
  ::setenv(kBusUrlVariable, test::bus_url().c_str(), 1);
  const auto [code, output, log] = doctor({"--json"});
  EXPECT_TRUE(finding(Json::parse(output), "nodes").is_object()) << output;
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

// A person reads it in the car: what is to be done comes first, what is well takes a line of each kind.
TEST_F(Doctor, SaysFirstWhatIsToBeDoneAndWhatIsWellInFewLines) {
  const auto [code, output, log] =
      doctor({"--vehicle", vehicle("[\"sim:?seed=1\", \"can:nobody0\"]"), "--node", "front"});
  EXPECT_EQ(code, 1);
  EXPECT_EQ(output.find("ill   node front: can:nobody0"), 0U) << output;
  std::istringstream lines(output);
  std::vector<std::string> marks;
  for (std::string line; std::getline(lines, line);)
    if (!line.starts_with("        mend it with: ")) marks.push_back(line.substr(0, line.find(' ')));
  const std::vector<std::string> order{"ill", "note", "ok"};
  const auto place = [&](const std::string& mark) { return std::ranges::find(order, mark) - order.begin(); };
  EXPECT_TRUE(std::ranges::is_sorted(marks, {}, place)) << output;
  EXPECT_LE(std::ranges::count(marks, "ok"), 5) << output;
  for (const char* about : {"ok    bus: ", "ok    folder: ", "ok    devices: node front: sim:"})
    EXPECT_NE(output.find(about), std::string::npos) << about << "\n" << output;
  EXPECT_NE(output.find(" h of \"demonstration car\""), std::string::npos) << output;
}

TEST_F(Doctor, NamesNodesOfTheCarThatAreNotOnTheBus) {
  const auto [code, output, log] =
      doctor({"--json", "--url", test::bus_url(), "--vehicle", vehicle("[\"usb:1209:0001\"]")});
  EXPECT_EQ(code, 1);
  const Json said = Json::parse(output);
  const std::string missing = finding(said, "nodes").dump();
  EXPECT_NE(missing.find("Node front (1) was not heard"), std::string::npos) << output;
  EXPECT_FALSE(finding(said, "recorder")["ok"].get<bool>()) << output;
  EXPECT_TRUE(finding(said, "usb:1209:0001").is_null()) << "it is on another computer";
}

TEST_F(Doctor, NamesWhatCostsAccuracyWithTheCommandThatMendsIt) {
  const std::string file = vehicle("[\"sim:\"]");
  const auto before = doctor({"--json", "--vehicle", file, "--node", "front"});
  const Json sigma = finding(Json::parse(before.output), "sigma");
  ASSERT_TRUE(sigma.is_object()) << before.output;
  EXPECT_FALSE(sigma["needed"].get<bool>()) << sigma;
  ASSERT_EQ(std::system(sigma["remedy"].get<std::string>().c_str()), 0) << sigma;
  const auto after = doctor({"--json", "--vehicle", file, "--node", "front"});
  EXPECT_TRUE(finding(Json::parse(after.output), "sigma").is_null()) << after.output;
}

TEST_F(Doctor, NamesWhatIsWrongWithTheQuestion) {
  EXPECT_EQ(doctor({"--vehicle", vehicle("[\"sim:\"]"), "--node", "middle"}).code, 2);
  EXPECT_EQ(doctor({"--node", "front"}).code, 2);
  EXPECT_EQ(doctor({"--answer"}).code, 2);
  EXPECT_EQ(doctor({"--messages", "0"}).code, 2);
  const auto none = doctor({"--json", "--url", "udpm://nowhere"});
  EXPECT_EQ(none.code, 1);
  EXPECT_NE(none.output.find("LCM does not start"), std::string::npos) << none.output;
}

}  // namespace
}  // namespace roadbalance

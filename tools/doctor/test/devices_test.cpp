#include "tools/doctor/devices.hpp"

#include <gtest/gtest.h>

#include "common/test/source.hpp"

namespace roadbalance {
namespace {

/// The demonstration's car with more keys of its node "front", and of the encoder of its front left wheel.
VehicleConfig car(const std::string& of_node, const std::string& of_encoder = "") {
  std::string text = test::read_source("sim/demo/vehicle.toml");
  const auto insert = [&text](const std::string& behind, const std::string& what) {
    const auto at = text.find(behind);
    ASSERT_NE(at, std::string::npos) << behind;
    text.insert(at + behind.size(), what);
  };
  insert("[wheel.encoder]\n", of_encoder);
  insert("[[node]]\nname = \"front\"\nid = 1\nrate_hz = 2000\n", of_node);
  return VehicleConfig::parse(text, "vehicle.toml");
}

int named(const std::vector<Finding>& findings, const std::string& name, Finding::State state) {
  int count = 0;
  for (const Finding& finding : findings) {
    if (finding.name != name) continue;
    EXPECT_EQ(finding.state, state) << finding.sentence;
    EXPECT_FALSE(finding.remedy.empty()) << finding.sentence;
    ++count;
  }
  return count;
}

// The warnings that rb-node gives at its start, before it starts.
TEST(DeviceFindings, NameWhatIsWiredAndNotRead) {
  const std::string wiring =
      "[[node.can]]\ninterface = \"can7\"\nrole = \"sensor\"\n"
      "[[node.line]]\nline = 0\ntooth_gpio = 4\nzero_mark_gpio = 5\n";
  const auto of = [](const VehicleConfig& vehicle) {
    return device_findings(vehicle, vehicle.node_named("front"));
  };
  EXPECT_EQ(named(of(car("front_end = [\"usb:1209:0001\"]\n" + wiring)), "unopened_wiring", Finding::kIll),
            2);
  EXPECT_EQ(named(of(car("front_end = [\"sim:\"]\n" + wiring)), "unopened_wiring", Finding::kIll), 0)
      << "it stands for all hardware";
  EXPECT_EQ(named(of(car(wiring)), "unopened_wiring", Finding::kIll), 0)
      << "no device at all is said instead";
}

TEST(DeviceFindings, NameWhatAnEncoderNeedsAndNobodyTells) {
  const VehicleConfig vehicle = car("front_end = [\"sim:\"]\n", "steering_ratio = 0.05\n");
  const auto findings = device_findings(vehicle, vehicle.node_named("front"));
  EXPECT_EQ(named(findings, "missing_signals", Finding::kNote), 1);
  const auto rear = device_findings(vehicle, vehicle.node_named("rear"));
  EXPECT_EQ(named(rear, "missing_signals", Finding::kNote), 0) << "it is the other node's";
}

}  // namespace
}  // namespace roadbalance

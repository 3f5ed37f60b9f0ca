#include "common/frontend/registry.hpp"

#include <gtest/gtest.h>

#include <array>
#include <utility>

#include "common/config/section.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

class Silence final : public FrontEnd {
 public:
  Read read(std::span<Scan>, std::span<Edge>, std::span<SignalSample>) noexcept override {
    return {.status = ReadStatus::kEnd};
  }
};

/// Gives one sample of its signal.
class Speed final : public SideSource {
 public:
  SideRead take(std::span<Edge>, std::span<SignalSample> signals) noexcept override {
    SideRead read{.complete_until = NodeTime::max()};
    if (signals.empty() || std::exchange(given_, true)) return read;
    signals[read.signals++] = {.signal = 4, .value = 27.5};
    return read;
  }
  std::vector<const DeviceReport*> reports() const override { return {&report_}; }

 private:
  bool given_ = false;
  DeviceReport report_{"can:can0"};
};

/// usb: gives scans, can: signals.
FrontEndRegistry house() {
  FrontEndRegistry registry;
  registry.add("usb", [](const FrontEndRequest&) { return std::make_unique<Silence>(); });
  registry.add("can", [](const FrontEndRequest&) { return std::make_unique<Speed>(); });
  return registry;
}

VehicleConfig car() {
  return VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "vehicle.toml");
}

TEST(FrontEndRegistry, OpensBySchemeAndHandsOverAddressVehicleAndNode) {
  const auto vehicle = car();
  std::string address;
  const NodeConfig* node = nullptr;
  FrontEndRegistry registry;
  registry.add("usb",
               [](const FrontEndRequest&) -> std::unique_ptr<FrontEnd> { throw ConfigError("wrong one"); });
  registry.add("replay", [&](const FrontEndRequest& request) {
    address = request.address;
    node = &request.node;
    EXPECT_EQ(&request.vehicle, &vehicle);
    return std::make_unique<Silence>();
  });
  EXPECT_NE(registry.open("replay:drive 1?rate=20:x", vehicle, vehicle.node[1]), nullptr);
  EXPECT_EQ(address, "drive 1?rate=20:x");
  EXPECT_EQ(node, &vehicle.node[1]);
  EXPECT_NE(registry.open("replay:", vehicle, vehicle.node[0]), nullptr);
  EXPECT_EQ(address, "");
}

TEST(FrontEndRegistry, NamesTheAddressAndWhatThereIs) {
  const auto vehicle = car();
  FrontEndRegistry registry;
  for (const char* scheme : {"sim", "can"})
    registry.add(scheme, [](const FrontEndRequest&) { return std::make_unique<Silence>(); });
  for (const std::string uri : {"gpio:0", "sim", "", ":sim", "SIM:"}) {
    try {
      registry.open(uri, vehicle, vehicle.node[0]);
      ADD_FAILURE() << uri;
    } catch (const ConfigError& error) {
      EXPECT_EQ(error.what(), "front end \"" + uri + "\": no such kind of front end; allowed: can:, sim:");
    }
  }
}

TEST(FrontEndRegistry, MakesOneFrontEndOfADeviceWithScansAndThoseBeside) {
  const auto vehicle = car();
  const auto both = house().open(std::vector<std::string>{"can:can0", "usb:"}, vehicle, vehicle.node[0]);
  std::array<Scan, 64> scans;
  std::array<Edge, 64> edges;
  std::array<SignalSample, 64> signals;
  const Read read = both->read(scans, edges, signals);
  ASSERT_EQ(read.signals, 1U);
  EXPECT_EQ(signals[0].signal, 4);
  EXPECT_EQ(signals[0].value, 27.5);
  EXPECT_EQ(read.status, ReadStatus::kEnd);
  const auto reports = both->reports();
  ASSERT_FALSE(reports.empty());
  EXPECT_EQ(reports.front()->device(), "can:can0");
}

TEST(FrontEndRegistry, LeavesADeviceThatStandsAloneAsItIs) {
  const auto vehicle = car();
  const auto alone = house().open(std::vector<std::string>{"usb:"}, vehicle, vehicle.node[0]);
  EXPECT_NE(dynamic_cast<Silence*>(alone.get()), nullptr);
}

TEST(FrontEndRegistry, WantsExactlyOneDeviceThatGivesScans) {
  const auto vehicle = car();
  const auto refusal = [&](const std::vector<std::string>& uris) -> std::string {
    try {
      house().open(uris, vehicle, vehicle.node[0]);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "opened";
  };
  EXPECT_EQ(refusal({}),
            "node front: no front end; allowed: one device that gives them, e.g. usb:1209:0001 or sim:");
  EXPECT_EQ(refusal({"can:can0", "can:can1"}),
            "node front: no scans come from can:can0, can:can1; allowed: one device that gives them, e.g. "
            "usb:1209:0001 or sim:");
  EXPECT_EQ(refusal({"usb:1", "can:can0", "usb:2"}),
            "front ends usb:1 and usb:2: both give scans; allowed: one that does");
  EXPECT_EQ(refusal({"usb:1", "gpio:0"}),
            "front end \"gpio:0\": no such kind of front end; allowed: can:, usb:");
}

}  // namespace
}  // namespace roadbalance

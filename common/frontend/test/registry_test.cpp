#include "common/frontend/registry.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace roadbalance

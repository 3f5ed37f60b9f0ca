#include "hil_tests/players/node_drive.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/config/section.hpp"
#include "common/test/source.hpp"
#include "sim/front_end.hpp"

namespace roadbalance::test {
namespace {

const VehicleConfig& vehicle() {
  static const VehicleConfig vehicle =
      VehicleConfig::read_file(source_path("hil_tests/players/demo/vehicle.toml"));
  return vehicle;
}

NodeDrive drive_of(const std::string& address) {
  const auto source = sim::open_sim_front_end({address, vehicle(), vehicle().node[0]});
  return read_drive(*source, "front", 1000.0);
}

TEST(NodeDrive, HoldsAllThatTheCarGives) {
  const NodeDrive drive = drive_of("?rate=max&seconds=2");
  EXPECT_EQ(drive.scans.size(), 2000U);
  EXPECT_EQ(drive.signals.size(), 200U * vehicle().node[0].wiring.signals());
  EXPECT_TRUE(std::ranges::is_sorted(drive.edges, {}, &Edge::time));
  EXPECT_GT(drive.edges.size(), 2U * 2U * 13U * 48U) << "two rings of 48 teeth, 13 turns a second";
  EXPECT_NEAR(drive.converter_ppm, 0.0, 1e-3);
}

// The scans' times are whole nanoseconds, so that over a second the rate is known to 1e-9.
TEST(NodeDrive, KnowsTheConvertersRate) {
  const NodeDrive drive = drive_of("?rate=max&seconds=2&converter_ppm=50");
  EXPECT_NEAR(drive.converter_ppm, 50.0, 2e-3);
  EXPECT_LE(drive.worst_stamp.count(), 1);
}

/// Scans of two instants, then a gap.
class Gap final : public FrontEnd {
 public:
  Read read(std::span<Scan> scans, std::span<Edge>, std::span<SignalSample>) noexcept override {
    scans[0].index = 0;
    scans[1].index = 2;
    return {.scans = 2, .status = ReadStatus::kEnd};
  }
  bool waits() const noexcept override { return true; }
};

std::string refusal(FrontEnd& source) {
  try {
    read_drive(source, "front", 2000.0);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "read";
}

TEST(NodeDrive, RefusesWhatCannotBePlayed) {
  Gap gap;
  EXPECT_NE(refusal(gap).find("node front: has a gap after scan 0"), std::string::npos) << refusal(gap);
  const auto live = sim::open_sim_front_end({"?rate=1", vehicle(), vehicle().node[0]});
  EXPECT_NE(refusal(*live).find("allowed: rate=max"), std::string::npos) << refusal(*live);
}

}  // namespace
}  // namespace roadbalance::test

// A drive as other programs hand it over, samples and pulses in two files, comes to the same result as
// the blocks of the nodes that measured it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "embedded/demo_vehicle.hpp"
#include "firmware/epoch_packer.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/analysis/identify/drive_estimator.hpp"
#include "sim/front_end.hpp"
#include "tools/import/import_samples.hpp"

namespace roadbalance {
namespace {

/// 500 scans a second, the rate identification works at, keep the files small.
VehicleConfig vehicle() {
  std::string text(embedded::kDemoVehicle);
  text = test::replaced(text, "\nrate_hz = 2000", "\nrate_hz = 500");
  text = test::replaced(text, "\ncutoff_hz = 200", "\ncutoff_hz = 60");
  return VehicleConfig::parse(text, "vehicle.toml");
}

std::unique_ptr<FrontEnd> drive(const VehicleConfig& vehicle, const NodeConfig& node) {
  return sim::open_sim_front_end({"?seed=4&seconds=90&rate=max", vehicle, node});
}

struct Log {
  std::vector<Scan> scans;
  std::vector<Edge> edges;
};

Log read_all(FrontEnd& front_end) {
  Log log;
  std::vector<Scan> scans(256);
  std::vector<Edge> edges(4096);
  for (Read read; read.status == ReadStatus::kOk;) {
    read = front_end.read(scans, edges, {});
    log.scans.insert(log.scans.end(), scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(read.scans));
    log.edges.insert(log.edges.end(), edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(read.edges));
  }
  return log;
}

class ImportDrive : public testing::Test {
 protected:
  /// One row an instant: nine digits of a second, seven of an acceleration.
  std::filesystem::path write_samples() {
    const std::filesystem::path path = folder_ / "samples.csv";
    std::FILE* const file = std::fopen(path.c_str(), "w");
    std::fprintf(file, "time_s");
    for (const NodeConfig& node : vehicle_.node)
      for (const auto& channel : node.channel) std::fprintf(file, ",%s", channel.name.c_str());
    std::fprintf(file, "\ns");
    for (const NodeConfig& node : vehicle_.node)
      for (std::size_t c = 0; c < node.channel.size(); ++c) std::fprintf(file, ",m/s^2");
    for (std::size_t row = 0; row < log_[0].scans.size(); ++row) {
      std::fprintf(file, "\n%.9f", 1e-9 * static_cast<double>(to_ns(log_[0].scans[row].time)));
      for (std::size_t n = 0; n < log_.size(); ++n)
        for (std::size_t c = 0; c < vehicle_.node[n].channel.size(); ++c)
          std::fprintf(file, ",%.7f", vehicle_.node[n].channel[c].to_si(log_[n].scans[row].counts[c]));
    }
    std::fprintf(file, "\n");
    EXPECT_EQ(std::fclose(file), 0);
    return path;
  }
  std::filesystem::path write_pulses() {
    std::multimap<NodeTime, std::string> rows;
    for (std::size_t n = 0; n < log_.size(); ++n)
      for (const Edge& edge : log_[n].edges) {
        const WheelConfig* const wheel = vehicle_.wheel_at(vehicle_.node[n], edge.line);
        EXPECT_NE(wheel, nullptr);
        rows.emplace(edge.time,
                     (wheel ? wheel->name : "none") + (edge.kind == EdgeKind::kTooth ? ",tooth" : ",zero"));
      }
    const std::filesystem::path path = folder_ / "pulses.csv";
    std::FILE* const file = std::fopen(path.c_str(), "w");
    std::fprintf(file, "time_s,wheel,kind\n");
    for (const auto& [time, row] : rows)
      std::fprintf(file, "%.9f,%s\n", 1e-9 * static_cast<double>(to_ns(time)), row.c_str());
    EXPECT_EQ(std::fclose(file), 0);
    return path;
  }

  const VehicleConfig vehicle_ = vehicle();
  std::vector<Log> log_;
  const test::TemporaryDirectory folder_;
};

TEST_F(ImportDrive, WithPulsesComesToTheResultOfTheNodesThemselves) {
  DriveEstimator direct(vehicle_);
  for (const NodeConfig& node : vehicle_.node) {
    log_.push_back(read_all(*drive(vehicle_, node)));
    pack_epoch(*drive(vehicle_, node), vehicle_, node, node.id,
               [&](const SealedBlock& block) { direct.consume(block); });
  }
  ASSERT_EQ(log_[0].scans.size(), log_[1].scans.size());

  const std::filesystem::path record = folder_ / "record";
  const auto report =
      import_samples({.samples = write_samples(), .pulses = write_pulses(), .folder = record}, vehicle_);
  EXPECT_TRUE(report.has_pulses);
  const auto identified = identify_record(record);

  for (std::size_t w = 0; w < kWheels; ++w) {
    const Balance& expected = direct.estimate().balance[w];
    const Balance& found = identified.estimate.balance[w];
    ASSERT_EQ(expected.state, Unknown::kNone) << kWheelNames[w];
    ASSERT_EQ(found.state, Unknown::kNone) << kWheelNames[w];
    // A value of seven decimals is within 5e-8 m/s^2, under a hundredth of a count of 50 m/s^2 / 2^23: after
    // rounding the counts are the same but for rare halves, and stamps within half a nanosecond.  The clock
    // fitted to the stamps may differ by as much over the drive.  The difference that is left is far below
    // one part in a million of the result.
    EXPECT_NEAR(found.unbalance_g, expected.unbalance_g, 1e-6 * expected.unbalance_g) << kWheelNames[w];
    EXPECT_NEAR(std::remainder(found.angle_rad - expected.angle_rad, 2.0 * std::numbers::pi), 0.0, 1e-6)
        << kWheelNames[w];
    const double stiffness = direct.estimate().identification.tyre_n_m[w];
    EXPECT_NEAR(identified.estimate.identification.tyre_n_m[w], stiffness, 1e-6 * stiffness);
  }
}

}  // namespace
}  // namespace roadbalance

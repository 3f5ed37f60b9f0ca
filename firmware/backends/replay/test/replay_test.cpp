#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/record/record_writer.hpp"
#include "common/test/temporary_directory.hpp"
#include "embedded/demo_vehicle.hpp"
#include "firmware/backends/replay/front_end.hpp"
#include "firmware/epoch_packer.hpp"
#include "sim/front_end.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kEpoch = 77;

struct Blocks {
  std::vector<SealedBlock> block;

  std::vector<const SealedBlock*> of(BlockKind kind) const {
    std::vector<const SealedBlock*> result;
    for (const SealedBlock& b : block)
      if (b.kind == kind) result.push_back(&b);
    return result;
  }
};

/// Passes on what a device gives, changed by the test.
class Altered final : public FrontEnd {
 public:
  using Alter = std::function<void(Scan&)>;
  Altered(std::unique_ptr<FrontEnd> inside, Alter alter)
      : inside_(std::move(inside)), alter_(std::move(alter)) {}
  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept override {
    Read read = inside_->read(scans, edges, signals);
    for (Scan& scan : scans.first(read.scans)) alter_(scan);
    // A speed signal as a car sends it, every tenth scan.
    for (const Scan& scan : scans.first(read.scans))
      if (scan.index % 10 == 0 && read.signals < signals.size())
        signals[read.signals++] = {scan.time, 2, 0.1 * static_cast<double>(scan.index)};
    return read;
  }
  bool waits() const noexcept override { return true; }

 private:
  std::unique_ptr<FrontEnd> inside_;
  Alter alter_;
};

class Replay : public ::testing::Test {
 protected:
  Blocks seal(FrontEnd& device, std::int64_t epoch = kEpoch) {
    Blocks blocks;
    pack_epoch(device, vehicle, node, epoch,
               [&](const SealedBlock& block) { blocks.block.push_back(block); });
    return blocks;
  }
  Blocks drive(const Altered::Alter& alter = [](Scan&) {}) {
    Altered device(sim::open_sim_front_end({"?seed=4&seconds=8&rate=max", vehicle, node}), alter);
    return seal(device);
  }
  void record(const Blocks& blocks) {
    RecordWriter writer({.folder = folder.path()});
    for (const SealedBlock& block : blocks.block) writer.append(block, 1);
    writer.close();
  }
  std::unique_ptr<FrontEnd> open(const std::string& query = "?rate=max") {
    return open_replay_front_end({folder.path().string() + query, vehicle, node});
  }

  VehicleConfig vehicle = VehicleConfig::parse(std::string(embedded::kDemoVehicle), "vehicle.toml");
  const NodeConfig& node = vehicle.node_named("front");
  const test::TemporaryDirectory folder;
};

void expect_same(const Blocks& first, const Blocks& second, BlockKind kind) {
  const auto a = first.of(kind), b = second.of(kind);
  ASSERT_EQ(a.size(), b.size());
  ASSERT_FALSE(a.empty());
  for (std::size_t k = 0; k < a.size(); ++k)
    ASSERT_TRUE(std::ranges::equal(a[k]->bytes(), b[k]->bytes())) << "block " << k;
}

TEST_F(Replay, MakesTheNodeSealTheSameBlocksAgain) {
  const Blocks recorded = drive();
  record(recorded);
  const Blocks again = seal(*open());
  for (const BlockKind kind : {BlockKind::kScan, BlockKind::kEdge, BlockKind::kSignal, BlockKind::kEnd})
    expect_same(recorded, again, kind);
}

// So few edges wait a second in the node, and then for the end of a long block of scans.
TEST_F(Replay, GivesNoEdgeBehindAYoungerScanWhereWheelsHaveFewPulses) {
  for (NodeConfig& one : vehicle.node) one.rate_hz = 125.0;
  for (WheelConfig& wheel : vehicle.wheel) wheel.encoder.pulses_per_turn = 8;
  record(drive());
  const auto device = open();
  std::vector<Edge> edges(100);
  std::vector<SignalSample> signals(100);
  std::size_t given = 0;
  NodeTime last{};
  for (ReadStatus status = ReadStatus::kOk; status == ReadStatus::kOk;) {
    Scan scan;
    const Read read = device->read({&scan, 1}, edges, signals);
    for (const Edge& edge : std::span(edges).first(read.edges)) EXPECT_GT(edge.time, last);
    given += read.edges;
    if (read.scans > 0) last = scan.time;
    status = read.status;
  }
  EXPECT_GT(given, 100u);
}

TEST_F(Replay, HasTheGapsOfTheRecordWithTheirCause) {
  // In 8 s the device loses half a second by itself and is unplugged for another.
  const Blocks recorded = drive([](Scan& scan) {
    if (scan.index >= 4'000) scan.index += 1'000;
    if (scan.index >= 10'000) {
      scan.index += 1'000;
      scan.after_absence = true;
    }
  });
  record(recorded);
  expect_same(recorded, seal(*open()), BlockKind::kGap);
  const auto gaps = recorded.of(BlockKind::kGap);
  ASSERT_EQ(gaps.size(), 2U);
  EXPECT_EQ(decode_gap(*gaps[0]).cause, GapCause::kDeviceOverrun);
  EXPECT_EQ(decode_gap(*gaps[1]).cause, GapCause::kDeviceGone);
}

TEST_F(Replay, GivesInRealTimeNoMoreThanIsDueAndAllInTheEnd) {
  record(drive());
  const WallTime begin = WallClock::now();  // not after that of the device, however long this thread waits
  const auto device = open("?rate=50");
  EXPECT_TRUE(device->waits());
  std::vector<Scan> scans(256);
  std::vector<Edge> edges(4096);
  std::vector<SignalSample> signals(256);
  std::int64_t total = 0;
  for (Read read; read.status == ReadStatus::kOk;) {
    read = device->read(scans, edges, signals);
    total += static_cast<std::int64_t>(read.scans);
    const double passed_s = std::chrono::duration<double>(WallClock::now() - begin).count();
    ASSERT_LE(static_cast<double>(total), 50.0 * 2000.0 * passed_s + 1.0);
  }
  EXPECT_EQ(total, 16'000);
}

TEST_F(Replay, TellsAtItsEndHowLateItWas) {
  record(drive());
  std::vector<std::string> told;
  const auto play = [&](const std::string& query) {
    const auto device = open_replay_front_end({folder.path().string() + query, vehicle, node},
                                              [&](const std::string& sentence) { told.push_back(sentence); });
    std::vector<Scan> scans(256);
    std::vector<Edge> edges(4096);
    std::vector<SignalSample> signals(256);
    while (device->read(scans, edges, signals).status == ReadStatus::kOk) EXPECT_TRUE(told.empty());
  };
  play("?rate=50");
  ASSERT_EQ(told.size(), 1U);
  EXPECT_TRUE(told[0].starts_with("replay:" + folder.path().string() + ": ")) << told[0];
  EXPECT_NE(told[0].find(" runs of scans: "), std::string::npos) << told[0];
  told.clear();
  play("?rate=max");  // nothing is due at any time
  EXPECT_TRUE(told.empty());
}

TEST_F(Replay, RefusesWhatIsNotThereByName) {
  const auto reason = [&](const std::string& query) -> std::string {
    try {
      open(query);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  record(drive());
  EXPECT_NE(reason("?speed=1").find("unknown key 'speed'; allowed: rate, epoch, node"), std::string::npos);
  EXPECT_NE(reason("?node=rear").find("no scan of node 2"), std::string::npos);
  EXPECT_NE(reason("?epoch=5").find("N one of 77"), std::string::npos);
  EXPECT_NE(reason("/nowhere").find("nowhere"), std::string::npos);

  Altered device(sim::open_sim_front_end({"?seed=5&seconds=1&rate=max", vehicle, node}), [](Scan&) {});
  record(seal(device, 88));
  EXPECT_NE(reason("").find("which run of node 1 to replay; allowed: epoch=N, N one of 77, 88"),
            std::string::npos);
  EXPECT_EQ(reason("?epoch=88"), "");
}

}  // namespace
}  // namespace roadbalance

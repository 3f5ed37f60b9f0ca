#include "firmware/node.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <system_error>

#include "common/bus/codec.hpp"
#include "common/process/parallel.hpp"
#include "common/record/record_reader.hpp"
#include "common/test/bus_url.hpp"
#include "firmware/spool_folder.hpp"
#include "firmware/test/little_recorder.hpp"
#include "firmware/test/scripted_front_end.hpp"
#include "firmware/test/vehicle.hpp"

namespace roadbalance {
namespace {

constexpr std::int32_t kNode = 3;
constexpr double kRate_hz = 2000.0;

// No recorder at first: more than the ring holds goes to the disk and comes back.
TEST(RunNode, DeliversWhatItHadToMoveToItsDiskAndLeavesNothingThere) {
  const std::string url = test::bus_url();
  const auto folder = std::filesystem::temp_directory_path() / ("rb-spool-" + std::to_string(::getpid()));
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::ScriptedFrontEnd device(test::marked_scans(0, 40'000, kRate_hz), {});
  test::LittleRecorder owner(url, kNode);
  owner.slow = true;
  Parallel processes;
  processes.run([&](std::stop_token stop) { owner.run(stop); });
  processes.run([&](std::stop_token stop) {
    run_node(stop, vehicle, vehicle.node[0], device,
             {.bus_url = url, .ring_bytes = std::size_t{512} << 10, .spool = folder});
  });
  processes.wait();
  EXPECT_GT(owner.most_spooled, 500);
  EXPECT_EQ(owner.last.scans_missing, 0);
  std::int64_t next = 0;
  for (const auto& [sequence, block] : owner.blocks)
    if (block.kind == BlockKind::kScan) {
      EXPECT_EQ(block.header.first_scan, next);
      next += block.header.scans;
    }
  EXPECT_EQ(next, 40'000);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove_all(folder);
}

TEST(RunNode, SavesWhatNoRecorderTookAndTheNextRunNamesIt) {
  const std::string url = test::bus_url();
  const auto folder = std::filesystem::temp_directory_path() / ("rb-spool-" + std::to_string(::getpid()));
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  std::string warned;
  const NodeOptions options{.bus_url = url,
                            .ring_bytes = std::size_t{1} << 20,
                            .spool = folder,
                            .warn = [&warned](const std::string& text) { warned += text + "\n"; }};
  {
    test::ScriptedFrontEnd device(test::marked_scans(0, 4000, kRate_hz), {});
    test::LittleRecorder owner(url, kNode);
    owner.takes_nothing = true;
    std::stop_source stop;
    owner.on_all_sealed = [&stop] { stop.request_stop(); };
    Parallel processes;
    processes.run([&](std::stop_token stop_here) { owner.run(stop_here); });
    processes.run([&](std::stop_token) {
      run_node(stop.get_token(), vehicle, vehicle.node[0], device, options);
      processes.request_stop();
    });
    processes.wait();
  }
  EXPECT_NE(warned.find("blocks that no recorder has stay in " + folder.string()), std::string::npos)
      << warned;
  warned.clear();
  std::stop_source stop;
  stop.request_stop();
  test::ScriptedFrontEnd nothing({}, {});
  run_node(stop.get_token(), vehicle, vehicle.node[0], nothing, options);
  EXPECT_NE(warned.find("an earlier run left blocks in " + folder.string()), std::string::npos) << warned;

  std::int64_t scans = 0;
  ASSERT_EQ(spools_left(folder, options.warn).size(), 1u);
  RecordReader reader(spools_left(folder, options.warn).front());
  reader.finish();
  SealedBlock block;
  while (const auto event = reader.next()) {
    ASSERT_EQ(accept(event->data, block), Refusal::kNone);
    if (block.kind == BlockKind::kScan) scans += block.header.scans;
  }
  EXPECT_EQ(scans, 4000);
  std::filesystem::remove_all(folder);
}

// The node stays, and its disk has failed since the recording before: the memory alone does.
TEST(RunNode, ALaterEpochIsMeasuredThoughItsSpoolCannotBeOpened) {
  const std::string url = test::bus_url();
  const auto folder = std::filesystem::temp_directory_path() / ("rb-spool-" + std::to_string(::getpid()));
  std::ofstream(folder) << "no folder";
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  std::string warned;
  const NodeOptions options{
      .bus_url = url, .spool = folder, .warn = [&warned](const std::string& text) { warned += text + "\n"; }};
  test::ScriptedFrontEnd device(test::marked_scans(0, 4000, kRate_hz), {});
  EXPECT_THROW(run_node({}, vehicle, vehicle.node[0], device, options), std::system_error) << "at the start";
  VehicleChange change(vehicle.text, false);
  test::LittleRecorder owner(url, kNode);
  Parallel processes;
  processes.run([&](std::stop_token stop) { owner.run(stop); });
  processes.run([&](std::stop_token stop) {
    const EpochResult epoch = run_epoch(stop, vehicle, vehicle.node[0], device, options, change, false);
    EXPECT_EQ(epoch.lost, 0);
  });
  processes.wait();
  EXPECT_EQ(owner.last.scans_sampled, 4000);
  EXPECT_EQ(owner.last.scans_missing, 0);
  EXPECT_EQ(owner.last.spool_failures, 1);
  EXPECT_NE(warned.find(folder.string()), std::string::npos) << warned;
  std::filesystem::remove_all(folder);
}

TEST(RunNode, SaysHowMuchIsLostIfNobodyTookItAndThereIsNoSpool) {
  const std::string url = test::bus_url();
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  std::string warned;
  test::ScriptedFrontEnd device(test::marked_scans(0, 4000, kRate_hz), {});
  test::LittleRecorder owner(url, kNode);
  owner.takes_nothing = true;
  std::stop_source stop;
  owner.on_all_sealed = [&stop] { stop.request_stop(); };
  std::int64_t lost = 0;
  Parallel processes;
  processes.run([&](std::stop_token stop_here) { owner.run(stop_here); });
  processes.run([&](std::stop_token) {
    lost = run_node(stop.get_token(), vehicle, vehicle.node[0], device,
                    {.bus_url = url, .ring_bytes = std::size_t{1} << 20, .warn = [&warned](const auto& text) {
                       warned += text + "\n";
                     }});
    processes.request_stop();
  });
  processes.wait();
  EXPECT_GT(lost, 4000 / kScansPerBlock);
  EXPECT_NE(warned.find(std::to_string(lost) + " blocks that no recorder has are lost"), std::string::npos)
      << warned;
}

}  // namespace
}  // namespace roadbalance

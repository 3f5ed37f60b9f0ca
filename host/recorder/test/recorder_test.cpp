#include "host/recorder/recorder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <set>
#include <system_error>
#include <thread>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/types.hpp"
#include "common/link/ring.hpp"
#include "common/link/sender.hpp"
#include "common/record/record_state.hpp"
#include "host/recorder/control/recording_session.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recorder/test/recorder_fixture.hpp"
#include "host/recording/preamble.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

TEST_F(RecorderTest, RecordsThreeNodesToTheirEndsThroughALossyNetwork) {
  options.nodes = {1, 2, 3};
  options.end_with_nodes = true;
  options.segment_bytes = 1 << 20;
  std::vector<std::unique_ptr<TestNode>> nodes;
  std::vector<std::jthread> threads;
  for (const int number : options.nodes) {
    nodes.push_back(std::make_unique<TestNode>(options.url, number, 1500, 0.1));
    threads.emplace_back([node = nodes.back().get()](std::stop_token stop) { node->run(stop); });
  }
  const RecorderReport report = run_recorder({}, options);
  ASSERT_EQ(report.node.size(), 3u);
  for (const auto& node : report.node) {
    EXPECT_EQ(node.samples_sent, 1500 * 20);
    EXPECT_EQ(node.samples_recorded, 1500 * 20);
    EXPECT_EQ(node.gaps, 0);
    EXPECT_TRUE(node.ended);
  }
  const Verification result = verify_record(options.folder);
  EXPECT_EQ(result.verdict, Verdict::kComplete);
  for (const std::string node : {"1", "2", "3"}) {
    const std::string gone = "devices of node " + node + ": was unplugged or went down (1 time by now)";
    EXPECT_EQ(std::ranges::count_if(result.notes, [&](const auto& n) { return n.ends_with(gone); }), 1);
  }
}

TEST_F(RecorderTest, AStopRequestEndsTheNodesAndWaitsForTheirLastBlocks) {
  std::stop_source stop;
  options.on_progress = [&](const RecorderReport& report) {
    if (!report.node.empty() && report.node[0].samples_recorded > 10'000) stop.request_stop();
  };
  TestNode node(options.url, 7, 1'000'000'000);
  const std::jthread thread([&node](std::stop_token ended) { node.run(ended); });
  const RecorderReport report = run_recorder(stop.get_token(), options);
  ASSERT_EQ(report.node.size(), 1u);
  EXPECT_TRUE(report.node[0].ended);
  EXPECT_EQ(report.node[0].samples_recorded, report.node[0].samples_sent);
  EXPECT_EQ(verify_record(options.folder).verdict, Verdict::kComplete);
}

// Who led it is gone by an error: the next recorder goes on with the same epoch, and nothing is missing.
TEST_F(RecorderTest, ASessionThatIsDroppedLeavesTheNodesMeasuring) {
  TestNode node(options.url, 7, 1'000'000'000);
  const std::jthread thread([&node](std::stop_token ended) { node.run(ended); });
  {
    RecordingSession session(options);
    const auto has_samples = [&session] {
      const auto report = session.view().report;
      return !report.node.empty() && report.node[0].samples_recorded > 10'000;
    };
    while (!has_samples() && !session.view().is_over) std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_FALSE(node.was_stopped());
  std::stop_source stop;
  options.on_progress = [&](const RecorderReport& report) {
    if (!report.node.empty() && report.node[0].samples_recorded > 20'000) stop.request_stop();
  };
  const RecorderReport report = run_recorder(stop.get_token(), options);
  EXPECT_TRUE(node.was_stopped());
  ASSERT_EQ(report.node.size(), 1u);
  EXPECT_EQ(report.node[0].gaps, 0);
  EXPECT_EQ(report.node[0].samples_recorded, report.node[0].samples_sent);
  EXPECT_EQ(verify_record(options.folder).verdict, Verdict::kComplete);
}

// A node that never hears that its end is durable never ends.
TEST_F(RecorderTest, RepeatsTheLastAckUntilTheNodeHasHeardIt) {
  options.nodes = {1};
  options.end_with_nodes = true;
  TestNode node(options.url, 1, 100);
  node.lose_last_acks(3);
  {
    const std::jthread thread([&node](std::stop_token stop) { node.run(stop); });
    run_recorder({}, options);
  }
  EXPECT_TRUE(node.holds_nothing());
}

TEST_F(RecorderTest, AStopRequestTooWaitsUntilTheNodeHasHeardTheLastAck) {
  std::stop_source stop;
  options.on_progress = [&](const RecorderReport& report) {
    if (!report.node.empty() && report.node[0].samples_recorded > 10'000) stop.request_stop();
  };
  TestNode node(options.url, 7, 1'000'000'000);
  node.lose_last_acks(3);
  {
    const std::jthread thread([&node](std::stop_token ended) { node.run(ended); });
    run_recorder(stop.get_token(), options);
  }
  EXPECT_TRUE(node.holds_nothing());
}

// The drive goes on: the nodes keep what was not promised, for a better disk or the next recorder.
TEST_F(RecorderTest, ADiskThatFailsDoesNotStopTheNodes) {
  std::stop_source stop;
  options.segment_bytes = 1 << 20;
  options.patience = milliseconds(500);
  TestNode node(options.url, 7, 1'000'000'000);
  std::atomic<bool> failing = false;
  options.on_progress = [&](const RecorderReport& report) {
    // The next segment cannot be made.  One that is being made may need another attempt.
    std::error_code ignored;
    if (!report.node.empty() && report.node[0].samples_recorded > 0) fs::remove_all(options.folder, ignored);
  };
  options.on_alive = [&](const RecorderStatus& status) {
    if (status.state != RecorderState::kDiskFailing || failing.exchange(true)) return;
    EXPECT_TRUE(node.was_started());
    EXPECT_FALSE(node.was_stopped());
    EXPECT_GT(status.disk_failures, 1);
    stop.request_stop();
  };
  {
    const std::jthread running([&node](std::stop_token ended) { node.run(ended); });
    EXPECT_THROW(run_recorder(stop.get_token(), options), std::runtime_error)
        << "what is not on the disk in the end is no success";
  }
  EXPECT_TRUE(failing);
  EXPECT_FALSE(node.holds_nothing());
}

TEST_F(RecorderTest, LeavesNodesAloneThatAreNotItsOwn) {
  options.nodes = {1};
  options.end_with_nodes = true;
  TestNode ours(options.url, 1, 2000);
  TestNode other(options.url, 2, 100);
  {
    const std::jthread first([&other](std::stop_token stop) { other.run(stop); });
    const std::jthread second([&ours](std::stop_token stop) { ours.run(stop); });
    const RecorderReport report = run_recorder({}, options);
    EXPECT_EQ(report.node.size(), 1u);
  }
  EXPECT_TRUE(ours.was_started());
  EXPECT_FALSE(other.was_started());
}

TEST_F(RecorderTest, EverySegmentDescribesItself) {
  options.nodes = {1};
  options.end_with_nodes = true;
  TestNode node(options.url, 1, 100);
  const std::jthread thread([&node](std::stop_token stop) { node.run(stop); });
  run_recorder({}, options);
  const auto described = read_description(options.folder);
  ASSERT_TRUE(described);
  EXPECT_TRUE(described->program.starts_with("roadbalance ")) << described->program;
  EXPECT_EQ(described->format_version, kRecordFormatVersion);
  EXPECT_EQ(described->types.size(), recorded_types().size());
  EXPECT_TRUE(fs::exists(options.folder / "manifest.json"));
}

TEST_F(RecorderTest, RecoversWhatItsRecordHolds) {
  options.nodes = {1};
  options.end_with_nodes = true;
  TestNode node(options.url, 1, 100);
  const std::jthread thread([&node](std::stop_token stop) { node.run(stop); });
  run_recorder({}, options);
  const RecordState recovered = read_state(options.folder);
  ASSERT_EQ(recovered.epoch.size(), 1u);
  const auto& epoch = recovered.epoch.begin()->second;
  EXPECT_EQ(epoch.position.contiguous, 101);
  EXPECT_EQ(epoch.position.next_scan, 2000);
  EXPECT_TRUE(epoch.position.ended);
  EXPECT_EQ(epoch.samples, 2000);
}

TEST_F(RecorderTest, GoesOnThoughItsIncarnationIsNoNumberWhenANodeObeysAHigherOne) {
  std::stop_source stop;
  Bus node(options.url);
  options.patience = milliseconds(100);
  options.on_alive = [&](const RecorderStatus& status) {
    std::ofstream(options.folder / kIncarnationFile) << "no number";
    node.publish(heartbeat_channel(7),
                 encode(Heartbeat{.node = 7, .epoch = 31, .owner = status.incarnation + 5}));
  };
  options.on_warning = [&](const std::string& sentence) {
    if (sentence.find("not a positive number") != std::string::npos) stop.request_stop();
  };
  EXPECT_NO_THROW(run_recorder(stop.get_token(), options));
  EXPECT_TRUE(stop.stop_requested());
}

TEST_F(RecorderTest, NamesTheFolderItCannotWriteTo) {
  options.folder = "/proc/no-such-folder";
  try {
    run_recorder({}, options);
    FAIL() << "recorded into /proc";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("no-such-folder"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace roadbalance

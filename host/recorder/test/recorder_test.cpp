#include "host/recorder/recorder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <set>
#include <system_error>
#include <thread>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/types.hpp"
#include "common/link/ring.hpp"
#include "common/link/sender.hpp"
#include "common/record/record.hpp"
#include "common/record/record_state.hpp"
#include "host/recorder/preamble.hpp"
#include "host/recorder/recording_session.hpp"
#include "host/recorder/verify.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

// A node without samples: fills its ring as fast as that is freed, from the start command to `blocks`.
class TestNode {
 public:
  TestNode(std::string url, std::int32_t number, std::int64_t blocks, double drop = 0)
      : number_(number), blocks_(blocks), drop_(drop), bus_(url), sender_(backlog_, number, kEpoch) {
    bus_.subscribe(ack_channel(number), [this](std::string_view, auto bytes) {
      const auto ack = decode_ack(bytes);
      if (!ack || (ended_ && ack->durable == ring_.next() - 1 && lost_last_acks_-- > 0)) return;
      sender_.take(*ack, WallClock::now());
    });
    bus_.subscribe(command_channel(number), [this](std::string_view, auto bytes) {
      if (const auto command = decode_command(bytes)) obey(*command);
    });
  }

  // Until everything is durable.
  void run(std::stop_token stop) {
    WallTime beat_at{};
    while (!stop.stop_requested() && !(ended_ && ring_.used() == 0)) {
      if (started_) produce();
      const WallTime now = WallClock::now();
      for (const std::int64_t sequence : sender_.due(now)) {
        const SealedBlock& block = ring_.get(sequence);
        if (drop_ > 0 && (++sent_ % static_cast<std::int64_t>(1 / drop_)) == 0)
          continue;  // the network loses it
        bus_.publish(block_channel(number_, block.kind), block.bytes());
      }
      if (now - beat_at > milliseconds(20)) {
        beat();
        beat_at = now;
      }
      bus_.handle(milliseconds(1));
    }
    beat();
  }

  /// The network loses the first `count` acks that say all is durable.
  void lose_last_acks(int count) { lost_last_acks_ = count; }

  // To be asked when run() is over.
  bool was_started() const { return started_; }
  bool was_stopped() const { return stopped_; }
  bool holds_nothing() const { return ring_.used() == 0; }

 private:
  static constexpr std::int64_t kEpoch = 31;

  void obey(const Command& command) {
    Reply reply{.node = number_, .epoch = kEpoch, .request = command.request, .sequence = ring_.next()};
    if (command.verb == Verb::kClaim && !sender_.claim(command.incarnation, WallClock::now()))
      reply.result = CommandError::kNotOwner;
    if (command.verb == Verb::kStart) started_ = true;
    if (command.verb == Verb::kStop) stopped_ = true;
    if (command.verb == Verb::kStop && started_) blocks_ = std::min(blocks_, ring_.next() - 1);
    bus_.publish(reply_channel(number_), encode(reply));
  }

  void produce() {
    while (!ended_) {
      SealedBlock* slot = ring_.claim();
      if (!slot) return;
      const std::int64_t sequence = ring_.next(), scans = 20 * (sequence - 1);
      const BlockHeader header{.node = number_,
                               .epoch = kEpoch,
                               .sequence = sequence,
                               .first_scan = scans,
                               .scans = 0,
                               .time_ns = scans};
      if (sequence > blocks_) {
        const auto sum = sum_.crc32c();
        seal(EndBlock{.header = header, .blocks = sequence, .scans_sealed = scans, .blocks_crc32c = sum},
             *slot);
        ended_ = true;
      } else {
        ScanBlock block{.header = header, .period_ps = 500'000'000};
        block.header.scans = 20;
        seal(block, *slot);
        sum_.add(*slot);
      }
      ring_.commit();
    }
  }

  void beat() {
    const NodeState state = ended_ ? NodeState::kEnded : started_ ? NodeState::kStarted : NodeState::kPreview;
    bus_.publish(heartbeat_channel(number_), encode(Heartbeat{.node = number_,
                                                              .epoch = kEpoch,
                                                              .base = ring_.base(),
                                                              .next = ring_.next(),
                                                              .state = state,
                                                              .owner = sender_.owner(),
                                                              .device_counts = {1}}));
  }

  const std::int32_t number_;
  std::int64_t blocks_;
  const double drop_;
  Bus bus_;
  Ring ring_{2000 * sizeof(SealedBlock)};
  Backlog backlog_{ring_};
  Sender sender_;
  int lost_last_acks_ = 0;
  std::atomic<bool> started_ = false;
  std::atomic<bool> stopped_ = false;
  bool ended_ = false;
  BlockSum sum_;
  std::int64_t sent_ = 0;
};

class RecorderTest : public ::testing::Test {
 protected:
  RecorderTest() {
    options.url = bus_url_on_port(20'000 + ::getpid() % 20'000);
    options.folder =
        fs::temp_directory_path() / ("rb-recorder-" + std::to_string(::getpid()) + "-" +
                                     ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(options.folder);
  }
  ~RecorderTest() override { fs::remove_all(options.folder); }

  RecorderOptions options;
};

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
    RecordingSession session(options, [](RecorderStatus&) {});
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

#include "firmware/node.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <numbers>
#include <set>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control.hpp"
#include "common/config/section.hpp"
#include "common/process/parallel.hpp"
#include "common/record/record.hpp"
#include "common/test/bus_url.hpp"
#include "firmware/spool_folder.hpp"
#include "firmware/test/scripted_front_end.hpp"
#include "firmware/test/vehicle.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

constexpr std::int32_t kNode = 3;
constexpr double kRate_hz = 2000.0;

/// A recorder in little: claims the node, starts it, keeps blocks in memory and loses every third datagram
/// the first time it sees it, so that repairs are needed.
class Owner {
 public:
  explicit Owner(const std::string& url) : bus_(url) {
    bus_.subscribe("RB_BLOCK_.*",
                   [this](std::string_view, std::span<const std::uint8_t> bytes) { take(bytes); });
    bus_.subscribe(heartbeat_channel(kNode), [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto beat = decode_heartbeat(bytes)) heard(*beat);
    });
    bus_.subscribe(reply_channel(kNode), [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto reply = decode_reply(bytes)) replies[reply->request] = *reply;
    });
  }

  /// Until the epoch is complete.
  void run(std::stop_token stop) {
    while (!stop.stop_requested() && !(end > 0 && received_through() == end && last.base > end)) {
      bus_.handle(std::chrono::milliseconds(20));
      if (last.epoch == 0) continue;
      if (!replies.contains(1)) say(1, Verb::kClaim);
      if (replies.contains(1) && !replies.contains(2)) say(2, Verb::kStart);
      if (takes_nothing || (slow && most_spooled <= 500)) continue;
      acknowledge();
    }
  }

  bool slow = false;           ///< takes nothing before the node had to move blocks to its disk
  bool takes_nothing = false;  ///< at all
  std::function<void()> on_all_sealed = [] {};
  std::int64_t most_spooled = 0;

  std::map<std::int64_t, SealedBlock> blocks;
  std::map<std::int64_t, Reply> replies;
  std::int64_t end = 0;
  Heartbeat last;

 private:
  void say(std::int64_t request, Verb verb) {
    bus_.publish(command_channel(kNode), encode(Command{kNode, request, 1, verb}));
  }
  void heard(const Heartbeat& beat) {
    last = beat;
    most_spooled = std::max(most_spooled, beat.spool_used);
    if (beat.state == NodeState::kEnded) on_all_sealed();
  }
  void take(std::span<const std::uint8_t> bytes) {
    SealedBlock block;
    ASSERT_EQ(accept(bytes, block), Refusal::kNone);
    const std::int64_t sequence = block.header.sequence;
    if (sequence % 3 == 0 && dropped_.insert({sequence, true}).second) return;
    if (block.kind == BlockKind::kEnd) end = sequence;
    blocks.emplace(sequence, block);
  }
  std::int64_t received_through() const {
    std::int64_t through = 0;
    for (auto it = blocks.find(1); it != blocks.end() && it->first == through + 1; ++it) ++through;
    return through;
  }
  void acknowledge() {
    Ack ack;
    ack.node = kNode;
    ack.epoch = last.epoch;
    ack.incarnation = 1;
    ack.number = ++number_;
    ack.received = ack.durable = received_through();
    ack.credit = ack.received + 2000;
    std::int64_t next = ack.received + 1;
    for (auto it = blocks.upper_bound(ack.received);
         it != blocks.end() && ack.missing.size() < kMaxMissingRanges; ++it) {
      if (it->first > next) ack.missing.push_back({next, it->first - 1});
      next = it->first + 1;
    }
    if (next < last.next && ack.missing.size() < kMaxMissingRanges)
      ack.missing.push_back({next, last.next - 1});
    bus_.publish(ack_channel(kNode), encode(ack));
  }

  Bus bus_;
  std::map<std::int64_t, bool> dropped_;
  std::int64_t number_ = 0;
};

TEST(RunNode, DeliversEveryScanOnceOverALossyBusAndEndsWhenAllIsDurable) {
  const std::string url = test::bus_url();
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  const sim::PulseTrain train{.angle_rad = [](double t) { return 2 * std::numbers::pi * 18.0 * t; }};
  test::ScriptedFrontEnd device(test::marked_scans(0, 4007, kRate_hz), train.edges(0.0, 2.1));
  Owner owner(url);
  Parallel processes;
  processes.run([&](std::stop_token stop) { owner.run(stop); });
  processes.run([&](std::stop_token stop) {
    run_node(stop, vehicle, vehicle.node[0], device, {.bus_url = url, .ring_bytes = std::size_t{1} << 20});
  });
  processes.wait();

  std::int64_t next = 0;
  for (const auto& [sequence, block] : owner.blocks) {
    if (block.kind != BlockKind::kScan) continue;
    EXPECT_EQ(block.header.first_scan, next);
    next += block.header.scans;
    const ScanBlock scan = decode_scan(block);
    for (std::int64_t row = 0; row < scan.header.scans; ++row)
      ASSERT_EQ(scan.counts[static_cast<std::size_t>(row)][5],
                test::marked_counts(scan.header.first_scan + row, 5));
  }
  EXPECT_EQ(next, 4007);
  EXPECT_EQ(owner.replies.at(2).result, CommandError::kNone);
  EXPECT_EQ(owner.last.scans_sampled, 4007);
  EXPECT_EQ(owner.last.scans_missing, 0);
  EXPECT_GE(owner.last.blocks_repaired, owner.end / 3);
  EXPECT_EQ(owner.last.state, NodeState::kEnded);
}

TEST(RunNode, DeliversSignalsAndSaysWhatItsDevicesSuffer) {
  const std::string url = test::bus_url();
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  DeviceReport can("can:can0"), usb("usb:");
  test::ScriptedFrontEnd device(test::marked_scans(0, 4000, kRate_hz), {});
  for (int k = 0; k < 300; ++k)
    device.signals.push_back({node_time_from_ns(k * 6'000'000), static_cast<std::uint16_t>(k % 3), 0.5 * k});
  device.devices = {&can, &usb};
  can.count(DeviceCounter::kGone);
  can.count(DeviceCounter::kBusErrors, 2);
  usb.count(DeviceCounter::kBusErrors, 3);
  std::mutex mutex;
  std::set<std::string> warned;
  const auto warn = [&](const std::string& sentence) {
    const std::lock_guard lock(mutex);
    warned.insert(sentence);
  };
  Owner owner(url);
  Parallel processes;
  processes.run([&](std::stop_token stop) { owner.run(stop); });
  processes.run([&](std::stop_token stop) {
    run_node(stop, vehicle, vehicle.node[0], device,
             {.bus_url = url, .ring_bytes = std::size_t{1} << 20, .warn = warn});
  });
  processes.wait();

  int next = 0;
  for (const auto& [sequence, block] : owner.blocks) {
    if (block.kind != BlockKind::kSignal) continue;
    for (const SignalSample& sample : decode_signal(block).unpack()) {
      EXPECT_EQ(to_ns(sample.time), next * 6'000'000);
      EXPECT_EQ(sample.signal, next % 3);
      EXPECT_EQ(sample.value, 0.5 * next);
      ++next;
    }
  }
  EXPECT_EQ(next, 300);
  std::array<std::int64_t, kDeviceCounters> sums{};
  sums[static_cast<std::size_t>(DeviceCounter::kGone)] = 1;
  sums[static_cast<std::size_t>(DeviceCounter::kBusErrors)] = 5;
  EXPECT_EQ(owner.last.device_counts, sums);
  EXPECT_EQ(warned, (std::set<std::string>{"can:can0: was unplugged or went down (1 time by now)",
                                           "can:can0: the controller saw errors on the bus (2 times by now)",
                                           "usb:: the controller saw errors on the bus (3 times by now)"}));
}

TEST(RunNode, SaysWhichEncoderHadTurnsWithoutTheirTeeth) {
  const std::string url = test::bus_url();
  auto vehicle = test::one_node_vehicle(kRate_hz);
  for (auto& wheel : vehicle.wheel) wheel.encoder.zero_mark = true;
  const sim::PulseTrain train{.angle_rad = [](double t) { return 2 * std::numbers::pi * 18.0 * t; },
                              .line = 1};
  std::vector<Edge> edges = train.edges(0.0, 2.1);
  // As if the kernel had taken two edges as one, and nobody knows of it.
  edges.erase(edges.begin() + 18 * 97 + 40);
  test::ScriptedFrontEnd device(test::marked_scans(0, 4007, kRate_hz), std::move(edges));
  std::mutex mutex;
  std::vector<std::string> warned;
  const auto warn = [&](const std::string& sentence) {
    const std::lock_guard lock(mutex);
    warned.push_back(sentence);
  };
  Owner owner(url);
  Parallel processes;
  processes.run([&](std::stop_token stop) { owner.run(stop); });
  processes.run([&](std::stop_token stop) {
    run_node(stop, vehicle, vehicle.node[0], device,
             {.bus_url = url, .ring_bytes = std::size_t{1} << 20, .warn = warn});
  });
  processes.wait();
  EXPECT_EQ(owner.last.encoder_faults, (std::array<std::int64_t, 2>{0, 1}));
  EXPECT_EQ(owner.last.device_counts[static_cast<std::size_t>(DeviceCounter::kFaultyTurns)], 1);
  EXPECT_EQ(warned,
            std::vector<std::string>{"encoder of line 1: turns came without exactly their teeth; they "
                                     "are flagged (1 time by now)"});
}

// No recorder at first: more than the ring holds goes to the disk and comes back.
TEST(RunNode, DeliversWhatItHadToMoveToItsDiskAndLeavesNothingThere) {
  const std::string url = test::bus_url();
  const auto folder = std::filesystem::temp_directory_path() / ("rb-spool-" + std::to_string(::getpid()));
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::ScriptedFrontEnd device(test::marked_scans(0, 40'000, kRate_hz), {});
  Owner owner(url);
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
    Owner owner(url);
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

TEST(RunNode, SaysHowMuchIsLostIfNobodyTookItAndThereIsNoSpool) {
  const std::string url = test::bus_url();
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  std::string warned;
  test::ScriptedFrontEnd device(test::marked_scans(0, 4000, kRate_hz), {});
  Owner owner(url);
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

TEST(RunNode, NamesARingThatIsTooSmall) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::ScriptedFrontEnd device({}, {});
  try {
    run_node({}, vehicle, vehicle.node[0], device,
             {.bus_url = test::bus_url(), .ring_bytes = 32 * sizeof(SealedBlock)});
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("node axle needs at least"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace roadbalance

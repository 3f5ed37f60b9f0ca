#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/types.hpp"
#include "common/link/ring.hpp"
#include "common/link/sender.hpp"
#include "common/record/record_state.hpp"
#include "host/recorder/recorder.hpp"

namespace roadbalance {

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
      if (now - beat_at > std::chrono::milliseconds(20)) {
        beat();
        beat_at = now;
      }
      bus_.handle(std::chrono::milliseconds(1));
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
    options.folder = std::filesystem::temp_directory_path() /
                     ("rb-recorder-" + std::to_string(::getpid()) + "-" +
                      ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(options.folder);
  }
  ~RecorderTest() override { std::filesystem::remove_all(options.folder); }

  RecorderOptions options;
};

}  // namespace roadbalance

#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "firmware/backends/usb/board_reader.hpp"
#include "firmware/backends/usb/board_setup.hpp"
#include "hil_tests/players/usb_board/bench_board.hpp"

namespace roadbalance::test {

inline constexpr auto kPowered = MachineTime(std::chrono::seconds(1000));

inline NodeTime as_node(MachineTime time) {
  return node_time_from_ns(to_ns(time));
}

/// The firmware of one or two boards in front of a reader, without USB and in a time of its own.
class BoardFeed {
 public:
  BoardFeed(std::vector<Bench> benches, VehicleConfig vehicle) : vehicle_(std::move(vehicle)) {
    for (Bench& bench : benches) {
      bench.powered = kPowered;
      board_.push_back(std::make_unique<BenchBoard>(std::move(bench)));
      report_.push_back(std::make_unique<DeviceReport>("usb:test"));
    }
    if (board_.size() > 1) board_[0]->connect_follower(*board_[1]);
    std::vector<DeviceReport*> reports;
    for (const auto& report : report_) reports.push_back(report.get());
    reader_ = std::make_unique<BoardReader>(reports, vehicle_.node[0].rate_hz,
                                            vehicle_.node[0].channel.size(), std::array{true, true});
  }

  BenchBoard& board(std::size_t k = 0) { return *board_[k]; }
  DeviceReport& report(std::size_t k = 0) { return *report_[k]; }
  BoardReader& reader() { return *reader_; }
  MachineTime now() const { return now_; }

  /// Plugs the boards in and starts a run.
  void begin() {
    BoardDelivery begin;
    begin.kind = BoardDelivery::Kind::kRunBegin;
    begin.run.token = ++token_;
    for (std::size_t k = 0; k < board_.size(); ++k) {
      board_[k]->reset();
      board_[k]->advance(now_);
      const auto identity = board::decode_identity(ask(k, board::Request::kIdentify));
      ASSERT_TRUE(identity);
      const BoardSetup setup = board_setup(vehicle_, vehicle_.node[0], *identity, k, board_.size());
      add_reply(k, board::Request::kConfigure, board::encode(setup.configuration));
      add_reply(k, board::Request::kReferences, board::encode(setup.references));
      begin.run.ticks_per_scan[k] = setup.configuration.ticks_per_scan;
      begin.run.tick_hz[k] = identity->tick_hz;
      begin.run.begin[k] = {board::decode_status(ask(k, board::Request::kStatus))->ticks, as_node(now_)};
    }
    reader_->take(begin);
    if (board_.size() > 1)
      add_reply(1, board::Request::kArm, board::encode(board::Arm{token_, board::StartMode::kFollower}));
    const auto mode = board_.size() > 1 ? board::StartMode::kMaster : board::StartMode::kImmediate;
    add_reply(0, board::Request::kArm, board::encode(board::Arm{token_, mode}));
    add_reply(0, board::Request::kStart, board::encode(board::Start{token_}));
  }

  /// Time passes; what the boards send arrives at once, or is lost while `losing`.
  void run(std::chrono::nanoseconds duration, bool losing = false) {
    for (const MachineTime end = now_ + duration; now_ < end;) {
      now_ = std::min(end, now_ + std::chrono::microseconds(500));
      for (auto& board : board_) board->advance(now_);
      for (std::size_t k = 0; k < board_.size(); ++k)
        while (k != not_fetched) {
          const std::size_t size = board_[k]->next_packet(delivery_.bytes);
          if (size == 0) break;
          if (losing) continue;
          delivery_.board = static_cast<std::uint8_t>(k);
          delivery_.arrival = as_node(now_);
          delivery_.size = static_cast<std::uint32_t>(size);
          shift_stamp(size);
          reader_->take(delivery_);
          hand_over();
        }
    }
  }

  void absent(std::chrono::nanoseconds duration) {
    for (auto& board : board_) board->reset();
    now_ += duration;
  }

  std::vector<Scan> scans;  ///< handed over so far
  std::vector<Edge> edges;
  std::size_t not_fetched = SIZE_MAX;  ///< board whose packets are not fetched
  std::uint64_t shift_ticks = 0;       ///< by which the next packet's stamps are wrong
  std::size_t scans_at_once = 256, edges_at_once = 4096;

 private:
  void shift_stamp(std::size_t size) {
    if (shift_ticks == 0) return;
    const auto bytes = std::span(delivery_.bytes).first(size);
    board::PacketHeader header = board::decode_packet(bytes)->header();
    header.base_ticks += std::exchange(shift_ticks, 0);
    board::encode_header(header, bytes.first<board::kHeaderBytes>());
    board::seal_packet(bytes);
  }
  void hand_over() {
    for (bool more = true; more;) {
      Read read;
      more = !reader_->hand_over(std::span(scan_).first(scans_at_once), std::span(edge_).first(edges_at_once),
                                 read);
      for (std::size_t k = 0; k < read.edges; ++k) {
        ASSERT_TRUE(scans.empty() || edge_[k].time > scans.back().time) << "behind a scan that follows it";
        edges.push_back(edge_[k]);
      }
      scans.insert(scans.end(), scan_.begin(), scan_.begin() + static_cast<std::ptrdiff_t>(read.scans));
    }
  }
  std::vector<std::uint8_t> ask(std::size_t k, board::Request request) {
    std::vector<std::uint8_t> reply(256);
    const auto size = board_[k]->control_request(
        {.request_type = board::kVendorIn, .request = static_cast<std::uint8_t>(request), .length = 256}, {},
        reply);
    reply.resize(size.value_or(0));
    return reply;
  }
  void add_reply(std::size_t k, board::Request request, std::span<const std::uint8_t> data) {
    ASSERT_TRUE(board_[k]->control_request({.request_type = board::kVendorOut,
                                            .request = static_cast<std::uint8_t>(request),
                                            .length = static_cast<std::uint16_t>(data.size())},
                                           data, {}));
  }

  const VehicleConfig vehicle_;
  std::vector<std::unique_ptr<BenchBoard>> board_;
  std::vector<std::unique_ptr<DeviceReport>> report_;
  std::unique_ptr<BoardReader> reader_;
  MachineTime now_ = kPowered + std::chrono::seconds(50);
  std::uint32_t token_ = 100;
  BoardDelivery delivery_;
  std::array<Scan, 256> scan_;
  std::array<Edge, 4096> edge_;
};

}  // namespace roadbalance::test

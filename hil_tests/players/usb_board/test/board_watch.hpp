#pragma once

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/frontend/registry.hpp"
#include "firmware/backends/usb/usb_device.hpp"
#include "firmware/backends/usb/usb_front_end.hpp"
#include "firmware/seal_all.hpp"
#include "firmware/test/vehicle.hpp"
#include "hil_tests/players/usb_board/usb_boards.hpp"
#include "hil_tests/program.hpp"

namespace roadbalance::test {

inline constexpr double kRateHz = 10'000.0;

/// Twelve channels at 10 kHz, two encoders.
inline VehicleConfig board_vehicle() {
  VehicleConfig vehicle = one_node_vehicle(kRateHz, 1000);
  vehicle.node[0].channel.resize(12, vehicle.node[0].channel[0]);
  vehicle.text = "# a car";
  return vehicle;
}

/// What conversion k of a run is at an input: channel 0 says k.
inline std::int32_t input_counts(std::int64_t k, std::size_t channel) {
  return channel == 0 ? static_cast<std::int32_t>(k & 0x3FFFFF)
                      : static_cast<std::int32_t>((k * 7919 + static_cast<std::int64_t>(channel) * 104'729) %
                                                  8'000'000) -
                            4'000'000;
}

inline Bench numbered_bench(const std::string& serial, double ppm = 0.0) {
  Bench bench;
  bench.serial = serial;
  bench.oscillator_ppm = ppm;
  bench.words = [](std::int64_t k, MachineTime) {
    board::ScanWords words{};
    for (std::size_t c = 0; c < board::kInputChannels; ++c)
      words[c] = static_cast<std::uint32_t>(input_counts(k, c)) & 0xFFFFFF;
    return words;
  };
  return bench;
}

/// Opens the front end; the kernel enumerates for some time after a board was plugged in.
/// @throws what the front end throws if it cannot be opened within five seconds
inline std::unique_ptr<FrontEnd> open_when_enumerated(
    const FrontEndRequest& request,
    const std::function<void(const std::string&)>& warn = [](const std::string&) {}) {
  for (int attempt = 0;; ++attempt) try {
      return open_usb_front_end(request, warn);
    } catch (const UsbError&) {
      if (attempt == 50) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}

/// A jump in the numbers of scans, and where the boards' own numbers stood.
struct Jump {
  Scan before, after;
  MachineTime came{};  ///< when the first scan behind it was read
};

/// Reads a front end as a node does, in a thread of real-time priority, checks every scan of numbered
/// benches, and seals what it reads.
class BoardWatch final : private FrontEnd {
 public:
  /// @param also  checks each scan, too
  BoardWatch(FrontEnd& front_end, const VehicleConfig& vehicle, std::function<void(const Scan&)> also = {})
      : inside_(front_end), vehicle_(vehicle), also_(std::move(also)) {
    thread_ = std::jthread([this] { seal(); });
    const sched_param priority{40};
    ::pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
  }
  ~BoardWatch() override { end(); }

  std::int64_t scans() const { return scans_.load(std::memory_order_relaxed); }
  bool more_scans(std::int64_t count) {
    const std::int64_t until = scans() + count;
    return wait_until([&] { return scans() >= until; }, 20.0);
  }
  /// Stops reading, as a node that is not scheduled.
  void hold(bool on) { held_.store(on, std::memory_order_relaxed); }

  /// Ends the epoch.  The following counts from then on.
  void end() {
    over_.store(true, std::memory_order_relaxed);
    if (thread_.joinable()) thread_.join();
  }
  const std::vector<Jump>& jumps() const { return jumps_; }
  const std::vector<GapBlock>& gaps() const { return gaps_; }
  const EndBlock& end_block() const { return end_; }
  std::int64_t edges() const { return edges_; }
  std::int64_t wrong_scans() const { return wrong_; }
  const Scan& last() const { return last_; }

 private:
  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept override {
    while (held_.load(std::memory_order_relaxed)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    Read read = inside_.read(scans, edges, signals);
    for (const Scan& scan : scans.first(read.scans)) look(scan);
    edges_ += static_cast<std::int64_t>(read.edges);
    if (over_.load(std::memory_order_relaxed)) read.status = ReadStatus::kEnd;
    return read;
  }

  void look(const Scan& scan) {
    const bool first = scans_.load(std::memory_order_relaxed) == 0;
    if (!first && scan.index != last_.index + 1 && jumps_.size() < 1000)
      jumps_.push_back({last_, scan, MachineClock::now()});
    // Within a run the board's own number goes as the index does; behind an absence it begins anew.
    const std::int64_t steps = scan.index - last_.index;
    bool right = first || scan.after_absence || scan.counts[0] - last_.counts[0] == steps;
    for (std::size_t c = 1; c < 6; ++c) right = right && scan.counts[c] == input_counts(scan.counts[0], c);
    if (!right || scan.overload != 0) ++wrong_;
    if (also_) also_(scan);
    last_ = scan;
    scans_.fetch_add(1, std::memory_order_relaxed);
  }

  void seal() {
    seal_all(*this, vehicle_, vehicle_.node[0], 7, [this](const SealedBlock& block) {
      if (block.kind == BlockKind::kGap) gaps_.push_back(decode_gap(block));
      if (block.kind == BlockKind::kEnd) end_ = decode_end(block);
    });
  }

  FrontEnd& inside_;
  const VehicleConfig& vehicle_;
  const std::function<void(const Scan&)> also_;
  std::atomic<bool> over_{false}, held_{false};
  std::atomic<std::int64_t> scans_{0};
  std::vector<Jump> jumps_;
  std::vector<GapBlock> gaps_;
  EndBlock end_{};
  std::int64_t edges_ = 0, wrong_ = 0;
  Scan last_{};
  std::jthread thread_;
};

}  // namespace roadbalance::test

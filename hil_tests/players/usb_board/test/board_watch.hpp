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
#include "firmware/epoch_packer.hpp"
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

/// At every so-manieth conversion one input after the other, but the first, is beyond its range.
inline constexpr std::int64_t kOverloads = 7001;
inline std::size_t overloaded_input(std::int64_t k) {
  const auto turn = static_cast<std::size_t>(k / kOverloads);
  return k % kOverloads == kOverloads - 1 ? 1 + turn % (board::kInputChannels - 1) : 0;
}

/// Value of conversion k of a run at an input: channel 0 has k.
inline std::int32_t input_counts(std::int64_t k, std::size_t channel) {
  if (channel > 0 && channel == overloaded_input(k)) return kFullScaleCounts - 1;
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

/// Its first input has the number of the conversion, the others its time: shared by two boards it shows
/// whether they converted at the same instant, whatever each counts.
inline Bench timed_bench(const std::string& serial, double ppm) {
  Bench bench;
  bench.serial = serial;
  bench.oscillator_ppm = ppm;
  bench.words = [](std::int64_t k, MachineTime time) {
    board::ScanWords words{};
    words[0] = static_cast<std::uint32_t>(k & 0x3FFFFF);
    for (std::size_t c = 1; c < board::kInputChannels; ++c) {
      const std::int64_t counts = (to_ns(time) / 100 + static_cast<std::int64_t>(c) * 104'729) % 8'000'000;
      words[c] = static_cast<std::uint32_t>(counts - 4'000'000) & 0xFFFFFF;
    }
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

/// Plugs the boards in and waits until one can be opened at the address, e.g. "usb:1209:0001".
inline void plug(UsbBoards& boards, const std::string& uri) {
  boards.plug();
  const VehicleConfig vehicle = board_vehicle();
  open_when_enumerated({uri.substr(uri.find(':') + 1), vehicle, vehicle.node[0]});
}

/// A jump in the numbers of scans, and where the boards' own numbers stood.
struct Jump {
  Scan before, after;
  MachineTime came{};  ///< when the first scan behind it was read
};

/// Another reader of the packets, and the number of inputs of a numbered bench.
struct AlsoLooks {
  std::function<void(const Scan&)> scan;
  std::function<void(const Edge&)> edge;
  std::size_t inputs = board::kInputChannels;
};

/// Ten times slower, by a sanitizer, it would keep the kernel's virtual host controller waiting, whose
/// threads are ordinary ones.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kReadsInRealTime = false;
#else
inline constexpr bool kReadsInRealTime = true;
#endif

/// Reads a front end as a node does, in a thread of real-time priority, checks every scan of numbered
/// benches, and seals what it reads.
class BoardWatch final : private FrontEnd {
 public:
  BoardWatch(FrontEnd& front_end, const VehicleConfig& vehicle, AlsoLooks also = {})
      : inside_(front_end), vehicle_(vehicle), also_(std::move(also)) {
    jumps_.reserve(kMostJumps);
    gaps_.reserve(kMostJumps);
    thread_ = std::jthread([this] { seal(); });
    const sched_param priority{40};
    if (kReadsInRealTime) ::pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
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
  std::int64_t wrong_scans() const { return wrong_; }
  const Scan& last() const { return last_; }

 private:
  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept override {
    while (held_.load(std::memory_order_relaxed)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    Read read = inside_.read(scans, edges, signals);
    for (const Scan& scan : scans.first(read.scans)) look(scan);
    if (also_.edge)
      for (const Edge& edge : edges.first(read.edges)) also_.edge(edge);
    if (over_.load(std::memory_order_relaxed)) read.status = ReadStatus::kEnd;
    return read;
  }

  void look(const Scan& scan) {
    const bool first = scans_.load(std::memory_order_relaxed) == 0;
    if (!first && scan.index != last_.index + 1 && jumps_.size() < kMostJumps)
      jumps_.push_back({last_, scan, MachineClock::now()});
    // Within a run the board's own number goes as the index does; behind an absence it begins anew.
    const std::int64_t steps = scan.index - last_.index;
    bool right = first || scan.after_absence || scan.counts[0] - last_.counts[0] == steps;
    for (std::size_t c = 1; c < also_.inputs; ++c)
      right = right && scan.counts[c] == input_counts(scan.counts[0], c);
    const std::size_t beyond = overloaded_input(scan.counts[0]);
    const bool is_beyond = beyond > 0 && beyond < also_.inputs;
    if (!right || scan.overload != (is_beyond ? 1u << beyond : 0u)) ++wrong_;
    if (also_.scan) also_.scan(scan);
    last_ = scan;
    scans_.fetch_add(1, std::memory_order_relaxed);
  }

  void seal() {
    pack_epoch(*this, vehicle_, vehicle_.node[0], 7, [this](const SealedBlock& block) {
      if (block.kind == BlockKind::kGap) gaps_.push_back(decode_gap(block));
      if (block.kind == BlockKind::kEnd) end_ = decode_end(block);
    });
  }

  static constexpr std::size_t kMostJumps = 1000;  ///< their memory is taken first, so that leaks show

  FrontEnd& inside_;
  const VehicleConfig& vehicle_;
  const AlsoLooks also_;
  std::atomic<bool> over_{false}, held_{false};
  std::atomic<std::int64_t> scans_{0};
  std::vector<Jump> jumps_;
  std::vector<GapBlock> gaps_;
  EndBlock end_{};
  std::int64_t wrong_ = 0;
  Scan last_{};
  std::jthread thread_;
};

}  // namespace roadbalance::test

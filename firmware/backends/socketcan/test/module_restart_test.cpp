#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "firmware/backends/socketcan/accelerometer_scans.hpp"
#include "firmware/readout_clock.hpp"

// Scans of a module that was switched off and on stand beside encoder edges of another device: their times
// have to be right at once, whatever the module's count.
namespace roadbalance {
namespace {

constexpr double kShortest_s = 100e-6;  // delay of a frame that never gets less
constexpr double kDelay_s = 200e-6;     // and what comes on top, on average

/// The frames a node gets of a module: read as they came.
class Heard final : public FrontEnd {
 public:
  explicit Heard(bool is_fd) : is_fd_(is_fd) {}

  /// Conversions [0, count) since the module was switched on.
  void convert(std::int64_t count, double on_s) {
    for (std::int64_t k = 0; k < count; ++k) {
      const double conversion_s = on_s + 1e-3 * static_cast<double>(k);
      arrived_s_ = std::max(arrived_s_ + 1e-9, conversion_s + kShortest_s + delay_(random_));
      const NodeTime time = node_time_from_ns(std::llround(1e9 * arrived_s_));
      for (int part = 0; part < (is_fd_ ? 1 : AccelerometerFrame::kParts); ++part) {
        AccelerometerFrame frame;
        frame.sequence = static_cast<std::uint32_t>(k);
        if (!is_fd_) {
          frame.part = part;
          frame.sequence &= 0xFF;
        }
        const auto scan = scans_.add(frame, time, false);
        if (!scan) continue;
        scan_.push_back(*scan);
        conversion_s_.push_back(conversion_s);
      }
    }
  }

  Read read(std::span<Scan> scans, std::span<Edge>, std::span<SignalSample>) noexcept override {
    std::copy(scan_.begin(), scan_.end(), scans.begin());
    return {.scans = scan_.size(), .status = ReadStatus::kEnd};
  }
  ScanStamps scan_stamps() const noexcept override { return ScanStamps::kReadOut; }
  const std::vector<double>& conversion_s() const { return conversion_s_; }

 private:
  const bool is_fd_;
  AccelerometerScans scans_;
  std::vector<Scan> scan_;
  std::vector<double> conversion_s_;  ///< of each scan, in truth
  double arrived_s_ = 0.0;
  std::mt19937_64 random_{1};
  std::exponential_distribution<double> delay_{1.0 / kDelay_s};
};

TEST(ModuleRestart, LeavesTheTimesOfItsScansRight) {
  for (const bool is_fd : {true, false})
    // Off for 0.1 to 2.1 s; the eight bits disagree with the stamps by anything up to half a turn.
    for (const double off_s : {0.1004, 0.3, 0.5496, 1.0, 2.1}) {
      Heard module(is_fd);
      constexpr std::int64_t kBefore = 40'000;
      module.convert(kBefore, 7.0);
      const double on_s = 47.0 + off_s;
      module.convert(60'000, on_s);
      std::vector<Scan> scans(module.conversion_s().size());
      ConversionTimes(module, AccelerometerScans::kRateHz).read(scans, {}, {});
      double worst_s = 0.0, settled_s = 0.0;
      for (std::size_t k = kBefore; k < scans.size(); ++k) {
        const double late_s = to_seconds(scans[k].time.time_since_epoch()) - module.conversion_s()[k];
        worst_s = std::max(worst_s, std::abs(late_s - kShortest_s));
        if (k >= kBefore + 3'000) settled_s = std::max(settled_s, std::abs(late_s - kShortest_s));
      }
      // The line begins at a stamp that is late by some delays, and goes to the earliest by 1 ms a second; an
      // index counts whole periods, from which a line that went on would be off by up to half of one.
      EXPECT_LT(settled_s, 0.25 * kDelay_s) << (is_fd ? "CAN FD, " : "classic, ") << off_s;
      EXPECT_LT(worst_s, 10 * kDelay_s) << (is_fd ? "CAN FD, " : "classic, ") << off_s;
      EXPECT_TRUE(scans[kBefore].after_absence);
      EXPECT_NEAR(static_cast<double>(scans[kBefore].index), kBefore + 1e3 * off_s, 3.0);
    }
}

}  // namespace
}  // namespace roadbalance

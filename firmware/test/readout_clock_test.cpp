#include "firmware/readout_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "common/test/no_allocation.hpp"

namespace roadbalance {
namespace {

constexpr double kRate_hz = 2000.0;
constexpr double kShortest_s = 30e-6;  // delay of reading that never gets less

struct Device {
  std::vector<Scan> scans;  ///< stamped when read
  std::vector<double> conversion_s;
};

/// Scans of a converter `ppm` fast, read in bunches of `bunch` and late by an exponential delay, now and then
/// by 80 ms.
Device device(double seconds, double ppm, std::size_t bunch, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::exponential_distribution<double> delay(1.0 / 200e-6);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Device out;
  double last_read_s = 0.0;
  const auto n = static_cast<std::size_t>(seconds * kRate_hz);
  for (std::size_t k = 0; k < n; ++k) {
    out.conversion_s.push_back(7.0 + static_cast<double>(k) / (kRate_hz * (1.0 + 1e-6 * ppm)));
    Scan scan;
    scan.index = static_cast<std::int64_t>(k);
    out.scans.push_back(scan);
    if (out.scans.size() % bunch != 0 && k + 1 != n) continue;
    const double hiccup_s = uniform(random) < 0.002 ? 0.08 : 0.0;
    const double read_s =
        std::max(last_read_s, out.conversion_s.back() + kShortest_s + delay(random) + hiccup_s);
    last_read_s = read_s;
    // A bunch has one stamp: its last scan is hardly late, its first by the whole bunch.
    for (std::size_t i = out.scans.size() - (k % bunch + 1); i <= k; ++i)
      out.scans[i].time = node_time_from_ns(std::llround(read_s * 1e9));
  }
  return out;
}

void correct(ReadoutClock& clock, std::vector<Scan>& scans) {
  for (std::size_t i = 0; i < scans.size(); i += 64)
    clock.correct(std::span(scans).subspan(i, std::min<std::size_t>(64, scans.size() - i)));
}

TEST(ReadoutClock, FindsTheInstantsOfConversion) {
  for (const double ppm : {-80.0, 0.0, 50.0})
    for (const std::size_t bunch : {1U, 10U}) {
      Device d = device(60.0, ppm, bunch, 3);
      ReadoutClock clock(kRate_hz);
      correct(clock, d.scans);
      for (std::size_t k = static_cast<std::size_t>(10 * kRate_hz); k < d.scans.size(); ++k) {
        const double late_s =
            to_seconds(d.scans[k].time.time_since_epoch()) - d.conversion_s[k] - kShortest_s;
        // 2000 or 200 delays of 200 us on average in a second: the least is 1 us or less; the hull adds
        // little.
        ASSERT_NEAR(late_s, 0.0, 10e-6) << ppm << " ppm, bunch " << bunch << ", scan " << k;
      }
    }
}

TEST(ReadoutClock, TimesRiseEvenly) {
  Device d = device(40.0, 40.0, 10, 4);
  ReadoutClock clock(kRate_hz);
  correct(clock, d.scans);
  for (std::size_t k = 1; k < d.scans.size(); ++k) {
    const double step_s = to_seconds(d.scans[k].time - d.scans[k - 1].time);
    ASSERT_NEAR(step_s * kRate_hz, 1.0, 1.1e-3) << k;  // following by 0.1 %, and a nanosecond's rounding
  }
}

TEST(ReadoutClock, LostScansLeaveTheOthersWhereTheyWere) {
  Device d = device(20.0, 30.0, 1, 5);
  d.scans.erase(d.scans.begin() + 9000, d.scans.begin() + 15000);
  ReadoutClock clock(kRate_hz);
  correct(clock, d.scans);
  for (std::size_t k = 8000; k < d.scans.size(); ++k) {
    const double true_s = d.conversion_s[static_cast<std::size_t>(d.scans[k].index)];
    ASSERT_NEAR(to_seconds(d.scans[k].time.time_since_epoch()) - true_s, kShortest_s, 15e-6) << k;
  }
}

TEST(ReadoutClock, BeginsAnewWhenTheClockJumps) {
  Device d = device(20.0, 0.0, 1, 6);
  for (std::size_t k = 20'000; k < d.scans.size(); ++k) d.scans[k].time += std::chrono::seconds(5);
  ReadoutClock clock(kRate_hz);
  correct(clock, d.scans);
  for (std::size_t k = 22'000; k < d.scans.size(); ++k)
    ASSERT_NEAR(to_seconds(d.scans[k].time.time_since_epoch()) - 5.0 - d.conversion_s[k], kShortest_s,
                400e-6);
}

/// Hands out what it was given, as read.
class Late final : public FrontEnd {
 public:
  Late(std::vector<Scan> scans, ScanStamps stamps) : scans_(std::move(scans)), stamps_(stamps) {}
  Read read(std::span<Scan> scans, std::span<Edge>, std::span<SignalSample>) noexcept override {
    std::copy(scans_.begin(), scans_.end(), scans.begin());
    return {.scans = scans_.size(), .status = ReadStatus::kEnd};
  }
  ScanStamps scan_stamps() const noexcept override { return stamps_; }

 private:
  std::vector<Scan> scans_;
  ScanStamps stamps_;
};

TEST(ConversionTimes, LeavesInstantsOfConversionAlone) {
  const Device d = device(20.0, 40.0, 10, 8);
  std::vector<Scan> read(d.scans.size());
  Late converted(d.scans, ScanStamps::kConversion), read_out(d.scans, ScanStamps::kReadOut);
  ConversionTimes(converted, kRate_hz).read(read, {}, {});
  for (std::size_t k = 0; k < read.size(); ++k) ASSERT_EQ(read[k].time, d.scans[k].time);
  ConversionTimes(read_out, kRate_hz).read(read, {}, {});
  EXPECT_NEAR(to_seconds(read.back().time.time_since_epoch()), d.conversion_s.back() + kShortest_s, 10e-6);
}

TEST(ReadoutClock, NeverAllocates) {
  Device d = device(5.0, 10.0, 10, 7);
  ReadoutClock clock(kRate_hz);
  const test::NoAllocation guard;
  correct(clock, d.scans);
}

}  // namespace
}  // namespace roadbalance

// The node's computer sleeps for a minute of the drive: identification takes the rest for what it is.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "common/record/record_writer.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/epoch_packer.hpp"
#include "firmware/sleep_gaps.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/recording/verify/verify.hpp"
#include "sim/front_end.hpp"
#include "sim/truth.hpp"
#include "tools/rb/test/simulated_drives.hpp"

namespace roadbalance {
namespace {

constexpr NodeTime kSleeps{std::chrono::seconds(100)}, kWakes{std::chrono::seconds(160)};
constexpr std::uint64_t kSeed = 4;

/// The simulated car's front end on a computer that sleeps: it converts nothing then, and numbers its scans
/// one by one.
class Sleeping final : public FrontEnd {
 public:
  explicit Sleeping(FrontEnd& inside) : inside_(inside) {}
  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept override {
    Read read = inside_.read(scans, edges.subspan(kEncoderLines), signals);
    const auto is_slept_through = [](const auto& one) { return one.time >= kSleeps && one.time < kWakes; };
    std::size_t scans_kept = 0, edges_kept = 0, signals_kept = 0;
    for (const Scan& scan : scans.first(read.scans)) {
      if (is_slept_through(scan)) continue;
      if (scan.time >= kWakes && !std::exchange(is_awake_again_, true))
        for (std::uint8_t line = 0; line < kEncoderLines; ++line)
          edges[edges_kept++] = {.time = kWakes, .line = line, .kind = EdgeKind::kLost};
      scans[scans_kept] = scan;
      scans[scans_kept++].index = next_++;
    }
    for (const Edge& edge : edges.subspan(kEncoderLines, read.edges))
      if (!is_slept_through(edge)) edges[edges_kept++] = edge;
    for (const SignalSample& sample : signals.first(read.signals))
      if (!is_slept_through(sample)) signals[signals_kept++] = sample;
    return {.scans = scans_kept, .edges = edges_kept, .signals = signals_kept, .status = read.status};
  }
  MachineClock::duration slept() const {
    return is_awake_again_ ? kWakes - kSleeps : MachineClock::duration{};
  }

 private:
  FrontEnd& inside_;
  bool is_awake_again_ = false;
  std::int64_t next_ = 0;
};

TEST(SleptDrive, IsIdentifiedAsWellAsItsDeviationsSay) {
  const test::TemporaryDirectory folder;
  const std::string record = folder / "record", scenario = test::source_path("sim/demo/scenario.toml");
  const VehicleConfig vehicle = VehicleConfig::parse(test::slow_car(), "vehicle.toml");
  RecordWriter writer({.folder = record});
  for (const NodeConfig& node : vehicle.node) {
    const auto device = sim::open_sim_front_end(
        {scenario + "?seed=" + std::to_string(kSeed) + "&seconds=260&rate=max", vehicle, node});
    Sleeping sleeping(*device);
    SleepGaps numbered(sleeping, node.rate_hz, [&] { return sleeping.slept(); });
    pack_epoch(numbered, vehicle, node, node.id,
               [&](const SealedBlock& block) { writer.append(block, 1000); });
  }
  writer.close();
  const Verification verified = verify_record(record);
  EXPECT_EQ(verdict_text(verified), "incomplete, every gap declared");
  for (const VerifiedEpoch& epoch : verified.epoch) {
    ASSERT_EQ(epoch.gaps.size(), 1u);
    EXPECT_EQ(epoch.gaps[0].cause, GapCause::kSlept);
    EXPECT_EQ(epoch.gaps[0].scans, 30'000);
  }
  const RecordedEstimate found = identify_record(record);
  const sim::Truth truth = sim::truth_of(scenario, kSeed, vehicle);
  double squares = 0.0;
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
    const Balance& balance = found.estimate.balance[wheel];
    ASSERT_EQ(balance.state, Unknown::kNone) << kWheelNames[wheel];
    const auto& true_one = truth.wheel[wheel];
    const double off_g = balance.unbalance_g - true_one.unbalance_g;
    const double off_rad = std::remainder(balance.angle_rad - true_one.angle_deg * std::numbers::pi / 180.0,
                                          2.0 * std::numbers::pi);
    std::printf("%s: %.1f g off by %.2f +- %.2f g, %.2f +- %.2f deg\n", kWheelNames[wheel],
                true_one.unbalance_g, off_g, balance.sigma_g, off_rad * 180.0 / std::numbers::pi,
                balance.sigma_rad * 180.0 / std::numbers::pi);
    squares += std::pow(off_g / balance.sigma_g, 2) + std::pow(off_rad / balance.sigma_rad, 2);
  }
  EXPECT_LT(squares, 20.09);  // chi^2 of 8, in 99 of 100 drives
}

}  // namespace
}  // namespace roadbalance

// Nodes with clocks of their own, from the simulated car through node, link, recorder and record to the
// signals that identification works on, in real time.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

#include "common/dsp/fractional_delay.hpp"
#include "common/process/parallel.hpp"
#include "common/test/bus_url.hpp"
#include "common/test/temporary_directory.hpp"
#include "embedded/demo_vehicle.hpp"
#include "firmware/epoch_packer.hpp"
#include "firmware/node.hpp"
#include "host/analysis/angle/read_with_angles.hpp"
#include "host/analysis/identify/assemble.hpp"
#include "host/recorder/recorder.hpp"
#include "sim/front_end.hpp"

namespace roadbalance {
namespace {

constexpr double kDrive_s = 7.0;

/// CLOCK_MONOTONIC, which paces the simulated drive, minus the host's clock, now.
double wall_minus_host_s() {
  std::int64_t narrowest_ns = INT64_MAX, difference_ns = 0;
  for (int i = 0; i < 20; ++i) {  // an interruption between two readings would shift the pair
    const MachineTime before = MachineClock::now();
    const auto wall = std::chrono::nanoseconds(WallClock::now().time_since_epoch()).count();
    const std::int64_t width_ns = (MachineClock::now() - before).count();
    if (width_ns >= narrowest_ns) continue;
    narrowest_ns = width_ns;
    difference_ns = wall - (to_ns(before) + width_ns / 2);
  }
  return 1e-9 * static_cast<double>(difference_ns);
}

class ClockDrive : public testing::Test {
 protected:
  ClockDrive()
      : vehicle_(VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml")) {
    scenario_ = files_ / "scenario.toml";
    // Nothing that differs between two looks at one drive: no sensor noise, no jitter of pulses.
    std::ofstream(scenario_) << "[[drive.plateau]]\nspeed_km_h = 100\nseconds = " << kDrive_s
                             << "\n[sensor]\nnoise_m_s2 = 0\n[encoder]\nstamp_jitter_us = 0\n";
  }

  /// The drive as two nodes of one clock sample it, its angles as live or computed again: column k at bus
  /// time k / 2000 s.
  SignalMatrix truth(AngleReprocessor::Teeth teeth) const {
    SignalMatrix all(kSignals, 0);
    Assembler assembler(vehicle_, [&](const SignalRun& run) {
      const Eigen::Index end = run.first_index + run.samples.cols();
      if (end > all.cols()) all.conservativeResize(Eigen::NoChange, end);
      all.middleCols(run.first_index, run.samples.cols()) = run.samples;
    });
    std::vector<SealedBlock> blocks;
    AngleReprocessor angles(vehicle_, AngleReprocessor::WithoutMark::kNoAngle, teeth);
    for (const NodeConfig& node : vehicle_.node) {
      const auto device = sim::open_sim_front_end({scenario_ + "?rate=max&seed=4", vehicle_, node});
      pack_epoch(*device, vehicle_, node, 1, [&](const SealedBlock& block) { blocks.push_back(block); });
    }
    for (const SealedBlock& block : blocks) angles.learn(block);
    for (const SealedBlock& block : blocks) assembler.consume(angles.reprocess(block));
    return all;
  }

  /// Drives in real time with clocks and converters all wrong, and records it.
  void record(WallTime start) {
    const std::vector<std::string> errors{"&clock_offset_s=-5000.25&clock_ppm=45&converter_ppm=-60",
                                          "&clock_offset_s=777.125&clock_ppm=-30&converter_ppm=80"};
    const std::string address = scenario_ + "?rate=1&seed=4&start_ns=" +
                                std::to_string(std::chrono::nanoseconds(start.time_since_epoch()).count());
    RecorderOptions options;
    options.url = test::bus_url();
    options.folder = record_;
    options.end_with_nodes = true;
    for (const NodeConfig& node : vehicle_.node) options.nodes.push_back(node.id);
    Parallel recorder, nodes;
    recorder.run([&](std::stop_token stop) { run_recorder(stop, options); });
    for (std::size_t n = 0; n < vehicle_.node.size(); ++n)
      nodes.run([&, n](std::stop_token stop) {
        const NodeConfig& node = vehicle_.node[n];
        const auto device = sim::open_sim_front_end({address + errors[n % 2], vehicle_, node});
        NodeOptions how;
        how.bus_url = options.url;
        run_node(stop, vehicle_, node, *device, how);
      });
    nodes.wait();
    recorder.wait();
  }

  test::TemporaryDirectory files_;
  const std::string record_ = files_ / "record";
  VehicleConfig vehicle_;
  std::string scenario_;
};

/// The signals of the truth at a bus time; nothing at its ends.
bool at(const SignalMatrix& truth, const FractionalDelay& delay, double bus_s, SignalVector& out) {
  const double place = bus_s * 2000.0;
  const auto before = static_cast<Eigen::Index>(std::floor(place));
  if (before < FractionalDelay::kBefore || before + FractionalDelay::kAfter >= truth.cols()) return false;
  out = truth.middleCols<FractionalDelay::kTaps>(before - FractionalDelay::kBefore) *
        delay.taps(place - std::floor(place));
  return true;
}

TEST_F(ClockDrive, ClocksAndConvertersDoNotShowInTheSignals) {
  const WallTime start = WallClock::now();
  const double begin_s = wall_minus_host_s();
  record(start);
  const double end_s = wall_minus_host_s();
  EXPECT_NEAR(end_s, begin_s, 0.02);  // however the system slews its clock, it is not set
  const double passed_s = std::chrono::duration<double>(WallClock::now() - start).count();

  const FractionalDelay delay;
  double uncertainty_live_s = 0.0;
  for (const bool refined : {false, true}) {
    const SignalMatrix truth =
        this->truth(refined ? AngleReprocessor::Teeth::kAgain : AngleReprocessor::Teeth::kAsLive);
    ASSERT_GT(truth.cols(), 13'000);
    const Eigen::VectorXd strength = truth.rowwise().norm() / std::sqrt(static_cast<double>(truth.cols()));
    std::optional<Assembler> assembler;
    double uncertainty_s = 0.0;
    SignalVector squares = SignalVector::Zero();
    Eigen::Index columns = 0;
    const auto compare = [&](const SignalRun& run) {
      for (Eigen::Index i = 0; i < run.samples.cols(); ++i) {
        const double since_last_s = 5e-4 * static_cast<double>(run.samples.cols() - 1 - i);
        const double host_s = 1e-9 * static_cast<double>(run.time_ns) - since_last_s;
        const double start_s = std::chrono::duration<double>(start.time_since_epoch()).count();
        const double slewed = (host_s + begin_s - start_s) / passed_s;
        const double bus_s = host_s + begin_s + slewed * (end_s - begin_s) - start_s;
        SignalVector expected;
        if (bus_s < 2.0 || !at(truth, delay, bus_s, expected)) continue;  // the filters settle
        SignalVector error = run.samples.col(i) - expected;
        if (refined && bus_s > kDrive_s - 0.1)  // behind the last tooth no angle can be had again
          error.tail<2 * kWheels>().setZero();
        squares += error.cwiseAbs2();
        ++columns;
      }
    };
    std::optional<AngleReprocessor> angles;
    read_with_angles(record_, refined, angles,
                     {.begin = [&](const VehicleConfig& vehicle) { assembler.emplace(vehicle, compare); },
                      .consume = [&](const SealedBlock& block) { assembler->consume(block); },
                      .consume_fit =
                          [&](const ClockFit& fit) {
                            if (fit.state == ClockState::kLocked)
                              uncertainty_s = std::max(uncertainty_s, fit.uncertainty_s);
                            assembler->consume(fit);
                          }});
    ASSERT_GT(columns, 8'000);
    EXPECT_EQ(angles.value().quality(0).has_value(), refined);  // whether its teeth were counted again
    // The first fits live know a second or so of exchanges, those computed again all of them.
    if (refined)
      EXPECT_LT(uncertainty_s, 0.1 * uncertainty_live_s);
    else
      uncertainty_live_s = uncertainty_s;
    // The wheels' signals lie below 15 Hz or so in the main: an error of time shows as 2 pi 15 Hz of it, 60
    // Hz at most.  Without clocks the difference would be that of two unrelated signals, 1.4 times their
    // strength.
    const double allowed = 2.0 * 3.1416 * 60.0 * (uncertainty_s + 20e-6) + 0.005;
    for (int s = 0; s < kSignals; ++s) {
      const double error = std::sqrt(squares(s) / static_cast<double>(columns)) / strength(s);
      std::printf("%s signal %2d: %.4f of its strength\n", refined ? "refined" : "live   ", s, error);
      EXPECT_LT(error, std::min(allowed, 0.2)) << "signal " << s << ", u " << uncertainty_s;
    }
  }
}

}  // namespace
}  // namespace roadbalance

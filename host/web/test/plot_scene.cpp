#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/order_report.hpp"
#include "common/bus/results.hpp"
#include "common/bus/setup.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/test/source.hpp"
#include "common/types/clocks.hpp"
#include "host/analyser/live_view.hpp"

// rb-web-plot-scene URL: the demonstration car's nodes as a formula, in real time, with the analyser's live
// view, so that a test of the plots knows what they must show.  Wheels turn kTurns_hz times a second.
//
//   fl_carrier_z  1.5 cos(a) + noise of 0.5 m/s^2, a the wheel's angle: first order
//   fr_carrier_z  half of that, three samples later
//   rl_carrier_z  0.4 cos(2 a) + noise of 0.1 m/s^2; every 8 s its node lacks half a second
//
// A sample is sent as soon as the last one of its block is due, and stamped with the machine's own clock.

namespace {

using namespace roadbalance;
using namespace std::chrono_literals;

constexpr double kRate_hz = 2000.0;
constexpr double kTurns_hz = 29.0 * kRate_hz / 4096.0;  // a bin of spectra of 4096
constexpr std::int64_t kPeriod_ns = 500'000;
constexpr std::int64_t kHoleEvery = 800, kHole = 50;  // blocks

double noise(std::int64_t k) {
  static const auto values = [] {
    std::vector<double> list(1U << 16U);
    std::mt19937 random(17);
    std::normal_distribution<double> normal;
    std::ranges::generate(list, [&] { return normal(random); });
    return list;
  }();
  return values[static_cast<std::size_t>(k) % values.size()];
}

double angle(std::int64_t k) {
  return 2.0 * std::numbers::pi * kTurns_hz * static_cast<double>(k) / kRate_hz;
}
double front(std::int64_t k) {
  return 1.5 * std::cos(angle(k)) + 0.5 * noise(k);
}

double acceleration(const std::string& channel, std::int64_t k) {
  if (channel == "fl_carrier_z") return front(k);
  if (channel == "fr_carrier_z") return 0.5 * front(k - 3);
  if (channel == "rl_carrier_z") return 0.4 * std::cos(2.0 * angle(k)) + 0.1 * noise(k + 7777);
  return 0.01 * noise(k + 31);
}

ScanBlock block_of(const NodeConfig& node, std::int64_t number, std::int64_t begin_ns) {
  ScanBlock block;
  const std::int64_t first = number * kScansPerBlock;
  block.header = {node.id, 9, number + 1, first, kScansPerBlock, begin_ns + first * kPeriod_ns};
  block.period_ps = kPeriod_ns * 1000;
  for (std::int64_t r = 0; r < kScansPerBlock; ++r) {
    const std::int64_t k = first + r + 10;
    auto& row = block.counts[static_cast<std::size_t>(r)];
    for (std::size_t c = 0; c < node.channel.size(); ++c) {
      const ChannelConfig& channel = node.channel[c];
      row[c] = static_cast<std::int32_t>(
          std::lround((acceleration(channel.name, k) - channel.to_si(0.0)) / channel.scale_m_s2_per_count));
    }
    for (std::size_t line = 0; line < kEncoderLines; ++line) {
      row[kAccelerations + 2 * line] =
          static_cast<std::int32_t>(kFullScaleCounts * 0.98 * std::sin(angle(k)));
      row[kAccelerations + 2 * line + 1] =
          static_cast<std::int32_t>(kFullScaleCounts * 0.98 * std::cos(angle(k)));
    }
  }
  return block;
}

/// The analyser's result for this record: front left 1.5 m/s^2 at 40 degrees, known to 5 %.
void publish_results(Bus& bus, const VehicleConfig& car) {
  for (const NodeConfig& node : car.node) {
    bus.publish(setup_channel(node.id), encode(setup_of(car, node)));
    bus.publish(
        clock_fit_channel(node.id),
        encode(ClockFit{
            .node = node.id, .epoch = 9, .number = 1, .state = ClockState::kLocked, .uncertainty_s = 5e-6}));
  }
  for (std::int32_t wheel = 0; wheel < kWheels; ++wheel) {
    OrderReport report{.wheel = wheel, .node = car.node[wheel < 2 ? 0 : 1].id, .seconds = 60.0};
    for (auto& order : report.order)
      for (auto& vector : order)
        vector = {std::polar(1.5 / (wheel + 1), 40.0 / 180.0 * std::numbers::pi), 0.075, 0.05, 40};
    if (wheel == 3)
      for (auto& vector : report.order[0]) vector.phase_95_rad = std::nan("");
    bus.publish(kOrdersChannel, encode(report));
    bus.publish(kBalanceChannel, encode(Balance{.wheel = wheel, .phase_drift_rad = wheel < 2 ? 2.0 : 0.5}));
  }
  bus.publish(kIdentificationChannel,
              encode(Identification{.seconds_used = 100.0,
                                    .speed_class = {{25.0, 60.0}, {31.0, 30.0}, {28.0, 10.0}}}));
}

}  // namespace

int main(int argc, char** argv) {
  const StopOnSignal signals;
  if (argc != 2) {
    std::fprintf(stderr, "usage: rb-web-plot-scene URL\n");
    return 2;
  }
  const VehicleConfig car = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  std::jthread view([&](const std::stop_token& stop) {
    live_view(
        stop, argv[1], car, {}, [](const auto&) {}, make_channel<Ack>(1).first);
  });
  Bus bus(argv[1]);
  SealedBlock sealed;
  const auto begin = MachineClock::now();
  for (std::int64_t number = 0; !signals.token().stop_requested(); ++number) {
    const auto due = begin + (number + 1) * kScansPerBlock * std::chrono::nanoseconds(kPeriod_ns);
    while (MachineClock::now() < due) std::this_thread::sleep_for(1ms);
    if (number % 50 == 0) publish_results(bus, car);
    for (const NodeConfig& node : car.node) {
      if (&node == &car.node[1] && number % kHoleEvery >= kHoleEvery - kHole) continue;
      const ScanBlock block = block_of(node, number, begin.time_since_epoch().count());
      seal(block, sealed);
      bus.publish(block_channel(node.id, sealed.kind), sealed.bytes());
    }
  }
  return 0;
}

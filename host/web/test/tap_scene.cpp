#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/setup.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/test/source.hpp"
#include "common/types/clocks.hpp"
#include "host/analyser/live_view.hpp"

// rb-web-tap-scene URL: the demonstration car at rest, in real time, with the analyser's live view.  A line
// "1.3" on standard input is a tap on that channel's sensor, the positive way along the car's axis: a push
// of 4 ms and a ringing that dies away, a sixth of it at the other sensors of its node, all through the
// anti-aliasing filter of vehicle.toml.  fr_carrier_z is fitted the wrong way round, against its direction in
// vehicle.toml.

namespace {

using namespace roadbalance;
using namespace std::chrono_literals;

constexpr double kRate_hz = 2000.0, kPush_m_s2 = 30.0, kPush_s = 0.004, kNoise_m_s2 = 0.005;
constexpr std::int64_t kPeriod_ns = 500'000;
constexpr double kFeltByOthers = 1.0 / 6.0;

/// Acceleration at the tapped place, so long after.
double tap_m_s2(double since_s) {
  if (since_s < 0.0 || since_s > 0.2) return 0.0;
  if (since_s < kPush_s) return kPush_m_s2 * std::sin(std::numbers::pi * since_s / kPush_s);
  const double ringing_s = since_s - kPush_s;
  return -0.5 * kPush_m_s2 * std::exp(-ringing_s / 0.01) *
         std::sin(2.0 * std::numbers::pi * 90.0 * ringing_s);
}

/// Place and time of the newest tap, from the thread that reads to the one that measures.
class Hammer {
 public:
  void hit(std::int32_t node, int channel) {
    const std::lock_guard lock(mutex_);
    node_ = node;
    channel_ = channel;
    is_new_ = true;
  }
  /// Accelerations of a node's sensors at a sample.
  double felt(std::int32_t node, int channel, std::int64_t sample) {
    const std::lock_guard lock(mutex_);
    if (std::exchange(is_new_, false)) begin_ = sample;
    if (node != node_) return 0.0;
    const double share = channel == channel_ ? 1.0 : kFeltByOthers;
    return share * tap_m_s2(static_cast<double>(sample - begin_) / kRate_hz);
  }

 private:
  std::mutex mutex_;
  std::int32_t node_ = 0;
  int channel_ = -1;
  std::int64_t begin_ = -1'000'000;
  bool is_new_ = false;
};

/// One node: sensors, filter and converter.
class Sensors {
 public:
  Sensors(const NodeConfig& node, const FilterConfig& filter)
      : node_(node),
        filter_(discretise_ramp_invariant(butterworth(filter.order, filter.cutoff_hz), 1.0 / kRate_hz),
                static_cast<Eigen::Index>(node.channel.size())) {}

  ScanBlock block(std::int64_t number, std::int64_t begin_ns, Hammer& hammer) {
    ScanBlock block;
    const std::int64_t first = number * kScansPerBlock;
    block.header = {node_.id, 9, number + 1, first, kScansPerBlock, begin_ns + first * kPeriod_ns};
    block.period_ps = kPeriod_ns * 1000;
    Eigen::ArrayXd sensed(node_.channel.size());
    for (std::int64_t r = 0; r < kScansPerBlock; ++r) {
      for (std::size_t c = 0; c < node_.channel.size(); ++c) {
        const ChannelConfig& channel = node_.channel[c];
        Eigen::Index axis = 0;
        channel.direction.cwiseAbs().maxCoeff(&axis);
        const double truth = channel.name == "fr_carrier_z" ? -1.0 : 1.0;
        sensed(static_cast<Eigen::Index>(c)) =
            truth * channel.direction(axis) * hammer.felt(node_.id, static_cast<int>(c), first + r) +
            kNoise_m_s2 * normal_(random_);
      }
      const Eigen::ArrayXd filtered = filter_.update(sensed).col(0);
      auto& row = block.counts[static_cast<std::size_t>(r)];
      for (std::size_t c = 0; c < node_.channel.size(); ++c) {
        const ChannelConfig& channel = node_.channel[c];
        row[c] = static_cast<std::int32_t>(std::lround(
            (filtered(static_cast<Eigen::Index>(c)) - channel.to_si(0.0)) / channel.scale_m_s2_per_count));
      }
      for (std::size_t line = 0; line < kEncoderLines; ++line)
        row[kAccelerations + 2 * line + 1] = kFullScaleCounts / 2;
    }
    return block;
  }

 private:
  const NodeConfig& node_;
  StateFilter filter_;
  std::mt19937 random_{23};
  std::normal_distribution<double> normal_{};
};

}  // namespace

int main(int argc, char** argv) {
  const StopOnSignal signals;
  if (argc != 2) {
    std::fprintf(stderr, "usage: rb-web-tap-scene URL\n");
    return 2;
  }
  const VehicleConfig car = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  std::jthread view([&](const std::stop_token& stop) {
    live_view(
        stop, argv[1], car, {}, [](const auto&) {}, make_channel<Ack>(1).first);
  });
  const auto hammer = std::make_shared<Hammer>();
  std::thread([hammer] {  // it may wait for input forever: it ends with the program
    std::int32_t node = 0;
    int channel = 0;
    for (char dot = 0; std::cin >> node >> dot >> channel;) hammer->hit(node, channel - 1);
  })
      .detach();
  Bus bus(argv[1]);
  SealedBlock sealed;
  std::map<std::int32_t, Sensors> sensors;
  for (const NodeConfig& node : car.node) sensors.try_emplace(node.id, node, car.filter);
  const auto begin = MachineClock::now();
  for (std::int64_t number = 0; !signals.token().stop_requested(); ++number) {
    const auto due = begin + (number + 1) * kScansPerBlock * std::chrono::nanoseconds(kPeriod_ns);
    while (MachineClock::now() < due) std::this_thread::sleep_for(1ms);
    for (const NodeConfig& node : car.node) {
      if (number % 50 == 0) bus.publish(setup_channel(node.id), encode(setup_of(car, node)));
      seal(sensors.at(node.id).block(number, begin.time_since_epoch().count(), *hammer), sealed);
      bus.publish(block_channel(node.id, sealed.kind), sealed.bytes());
    }
  }
  return 0;
}

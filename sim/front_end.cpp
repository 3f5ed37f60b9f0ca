#include "sim/front_end.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/frontend/pace.hpp"
#include "common/types/scan.hpp"
#include "sim/address.hpp"
#include "sim/car.hpp"
#include "sim/conditioner.hpp"
#include "sim/drawn_car.hpp"
#include "sim/drive.hpp"
#include "sim/signals.hpp"
#include "sim/tone_wheel.hpp"

namespace roadbalance::sim {
namespace {

/// The references of a node with loop-back: a frequency generator that knows each wheel's angle, D/A
/// converters of 16 bits, ten codes a scan, the anti-aliasing filter of vehicle.toml, and A/D converters.
///
/// A code stands for the middle of the time that it is held: it enters the filter as if there were straight
/// lines between the codes.
class LoopBack {
 public:
  LoopBack(const VehicleConfig& vehicle, const NodeConfig& node, const DrawnCar& car, double rate_hz);

  /// Goes on to scan number `scan`, each one in turn, and fills its references; of a node that computes them
  /// itself there is nothing to do.
  void convert(const Drive& drive, std::int64_t scan, Scan& out);

 private:
  static constexpr int kCodesPerScan = 10;
  static constexpr double kAmplitude = 0.9;
  struct Wheel {
    std::size_t line;
    double radius_m, initial_rad;
  };

  bool wanted_;
  double rate_hz_;
  std::vector<Wheel> wheel_;
  StateFilter filter_;  ///< rows sin, cos of line 0, of line 1
};

LoopBack::LoopBack(const VehicleConfig& vehicle, const NodeConfig& node, const DrawnCar& car, double rate_hz)
    : wanted_(node.wiring.loop_back),
      rate_hz_(rate_hz),
      filter_(discretise_ramp_invariant(butterworth(vehicle.filter.order, vehicle.filter.cutoff_hz),
                                        1.0 / (rate_hz * kCodesPerScan)),
              kReferences) {
  for (std::size_t line = 0; line < kEncoderLines; ++line)
    if (const WheelConfig* const wheel = vehicle.wheel_at(node, static_cast<int>(line))) {
      const auto w = static_cast<std::size_t>(vehicle.place_of(*wheel));
      wheel_.push_back({line, car.rolling_radius_m[w], car.initial_angle_rad[w]});
    }
}

void LoopBack::convert(const Drive& drive, std::int64_t scan, Scan& out) {
  if (!wanted_) return;
  Eigen::Array<double, kReferences, 1> code = Eigen::Array<double, kReferences, 1>::Zero();
  for (int k = 1; k <= kCodesPerScan; ++k) {
    const double time_s = (static_cast<double>(scan - 1) + static_cast<double>(k) / kCodesPerScan) / rate_hz_;
    const double position_m = drive.at(time_s).position_m;
    for (const Wheel& wheel : wheel_) {
      const double angle_rad = position_m / wheel.radius_m + wheel.initial_rad;
      const auto row = static_cast<Eigen::Index>(2 * wheel.line);
      code(row) = std::round(32767.0 * kAmplitude * std::sin(angle_rad)) / 32767.0;
      code(row + 1) = std::round(32767.0 * kAmplitude * std::cos(angle_rad)) / 32767.0;
    }
    filter_.update(code);
  }
  for (std::size_t r = 0; r < kReferences; ++r)
    out.references[r] = static_cast<std::int32_t>(
        std::lround(filter_.states()(static_cast<Eigen::Index>(r), 0) * kFullScaleCounts));
}

constexpr int kStepsPerScan = 2;
constexpr double kMostTurnsPerSecond = 60.0;  ///< 300 km/h, the fastest scenario, on a small wheel

/// One node of the simulated car, scan by scan, without any clock.
class Device {
 public:
  /// @param rate_hz  of the converter
  Device(const Scenario& scenario, std::uint64_t seed, const VehicleConfig& vehicle, const NodeConfig& node,
         double rate_hz)
      : rate_hz_(rate_hz),
        car_(scenario, seed, vehicle, 1.0 / (kStepsPerScan * rate_hz)),
        conditioner_(scenario, seed, vehicle, node, 1.0 / (kStepsPerScan * rate_hz)),
        loop_back_(vehicle, node, car_.drawn(), rate_hz),
        lead_scans_(std::ceil(kFarthestJitter * scenario.encoder.stamp_jitter_s * rate_hz)),
        wheels_at_{0.0, car_.drive().at(0.0)},
        edges_(edge_room(vehicle, node)),
        signals_(vehicle, node, car_.drawn(), seed) {
    for (int line = 0; line < kEncoderLines; ++line) {
      const WheelConfig* const wheel = vehicle.wheel_at(node, line);
      if (!wheel) continue;
      const auto w = static_cast<std::size_t>(vehicle.place_of(*wheel));
      tone_wheel_.emplace_back(scenario.encoder, seed, w, wheel->encoder, static_cast<std::uint8_t>(line),
                               car_.drawn().rolling_radius_m[w], car_.drawn().initial_angle_rad[w],
                               wheels_at_);
    }
  }

  /// Takes scan number next() of the drive.
  Scan take() {
    // The car stands at bus time 0 already, where the first scan is due.
    for (int i = 0; i < (next_ == 0 ? 1 : kStepsPerScan); ++i) {
      if (next_ > 0) car_.step();
      conditioner_.feed(car_.sources(), car_.steps());
    }
    const double ahead_s = (static_cast<double>(next_) + lead_scans_) / rate_hz_;
    const ToneWheel::Instant to{ahead_s, car_.drive().at(ahead_s)};
    for (ToneWheel& wheel : tone_wheel_) wheel.advance(wheels_at_, to, edges_);
    wheels_at_ = to;

    Scan scan;
    scan.time = node_time_from_ns(std::llround(static_cast<double>(next_) * 1e9 / rate_hz_));
    conditioner_.convert(scan);
    loop_back_.convert(car_.drive(), next_, scan);
    ++next_;
    return scan;
  }

  std::int64_t next() const { return next_; }
  /// Edges up to the last scan taken are complete.
  EdgeQueue& edges() { return edges_; }

  /// The next sample of a signal, if it is not later than `until`.
  std::optional<SignalSample> take_signal(NodeTime until) {
    const NodeTime time = node_time_from_ns(signal_instant_ * Signals::kPeriod_ns);
    if (signals_.size() == 0 || time > until) return std::nullopt;
    const SignalSample sample = signals_.at(signal_, signal_instant_, car_.drive());
    if (++signal_ == signals_.size()) signal_ = 0, ++signal_instant_;
    return sample;
  }

 private:
  static constexpr double kFarthestJitter = 3.4642;  ///< of RandomSequence::normal

  std::size_t edge_room(const VehicleConfig& vehicle, const NodeConfig& node) const {
    double pulses_per_turn = 0.0;
    for (int line = 0; line < kEncoderLines; ++line)
      if (const WheelConfig* const wheel = vehicle.wheel_at(node, line))
        pulses_per_turn += wheel->encoder.pulses_per_turn + 1;
    const double horizon_s = (2.0 * lead_scans_ + 2.0) / rate_hz_;
    return static_cast<std::size_t>(2.0 * pulses_per_turn * kMostTurnsPerSecond * horizon_s) + 64;
  }

  double rate_hz_;
  Car car_;
  Conditioner conditioner_;
  LoopBack loop_back_;
  double lead_scans_;  ///< tone wheels run this far ahead, so that no jittered stamp comes too late
  ToneWheel::Instant wheels_at_;
  std::vector<ToneWheel> tone_wheel_;
  EdgeQueue edges_;
  Signals signals_;
  std::size_t signal_ = 0;           ///< next to give,
  std::int64_t signal_instant_ = 0;  ///< of this instant, in periods
  std::int64_t next_ = 0;
};

/// A node's clock as it runs against bus time: offset_s at bus time 0, gaining `gain` of it.
struct ClockError {
  double offset_s = 0.0;
  double gain = 0.0;

  NodeTime operator()(NodeTime bus) const {
    if (offset_s == 0.0 && gain == 0.0) return bus;
    const auto ns = static_cast<double>(to_ns(bus));
    return bus + NodeClock::duration(std::llround(1e9 * offset_s + gain * ns));
  }
};

class SimFrontEnd final : public FrontEnd {
 public:
  SimFrontEnd(Device device, double rate_hz, double seconds, std::optional<Pace> pace, double from_s,
              ClockError clock)
      : device_(std::move(device)),
        rate_hz_(rate_hz),
        scans_(std::llround(seconds * rate_hz)),
        pace_(pace),
        clock_(clock) {
    if (pace_) from_s = std::max(from_s, pace_->drive_s(WallClock::now()));
    first_ = std::min(static_cast<std::int64_t>(std::ceil(std::min(from_s, seconds) * rate_hz)), scans_);
    while (device_.next() < first_) {
      const NodeTime time = device_.take().time;
      while (device_.edges().due(time)) device_.edges().take();
      while (device_.take_signal(time)) {
      }
    }
  }

  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept override {
    Read read;
    const std::int64_t due = wait(scans.size());
    if (pace_ && !taken_ && !pass_sleep(due, edges, read)) return read;
    while (read.scans < scans.size()) {
      if (!taken_) {
        if (device_.next() >= scans_) {
          read.status = ReadStatus::kEnd;
          return read;
        }
        if (device_.next() >= due) return read;
        taken_ = device_.take();
        taken_->index = device_.next() - 1 - first_;
      }
      for (; read.edges < edges.size() && device_.edges().due(taken_->time); ++read.edges) {
        edges[read.edges] = device_.edges().take();
        edges[read.edges].time = clock_(edges[read.edges].time);
      }
      for (; read.signals < signals.size(); ++read.signals) {
        const auto sample = device_.take_signal(taken_->time);
        if (!sample) break;
        signals[read.signals] = *sample;
        signals[read.signals].time = clock_(sample->time);
      }
      // The scan comes after its edges and samples; a reader that gives no room for samples wants none.
      if (device_.edges().due(taken_->time)) return read;
      if (read.signals == signals.size() && !signals.empty()) return read;
      scans[read.scans] = *taken_;
      scans[read.scans++].time = clock_(taken_->time);
      taken_.reset();
    }
    return read;
  }

  bool waits() const noexcept override { return !pace_ || pace_->rate() != 1.0; }

  NodeTime begins() const noexcept override {
    return clock_(node_time_from_ns(std::llround(1e9 * static_cast<double>(first_) / rate_hz_)));
  }
  NodeTime node_time(MachineTime machine) const noexcept override {
    return pace_ ? clock_(node_time_from_ns(pace_->drive_ns(machine))) : NodeTime{};
  }

 private:
  static constexpr auto kLongestWait = std::chrono::milliseconds(100);
  static constexpr double kRun_s = 5e-3;  ///< of wall time: a reader is not woken for every scan

  /// The car drives on while the computer is suspended, and nobody samples it.  Returns false while it is
  /// still to catch up: that is longer than a read may last.
  bool pass_sleep(std::int64_t due, std::span<Edge> edges, Read& read) noexcept {
    constexpr std::int64_t kScansAtOnce = 2000;
    const MachineClock::duration slept = pace_->slept();
    if (slept > slept_) {
      wakes_at_ = std::max(device_.next(), wakes_at_) +
                  std::llround(1e-9 * static_cast<double>((slept - slept_).count()) * rate_hz_);
      slept_ = slept;
    }
    if (device_.next() >= wakes_at_) return true;
    const std::int64_t until = std::min({wakes_at_, scans_, due, device_.next() + kScansAtOnce});
    NodeTime last{};
    while (device_.next() < until) {
      last = device_.take().time;
      while (device_.edges().due(last)) device_.edges().take();
      while (device_.take_signal(last)) {
      }
    }
    if (device_.next() < wakes_at_) return device_.next() >= scans_;
    for (std::uint8_t line = 0; line < kEncoderLines; ++line)
      edges[read.edges++] = {.time = clock_(last), .line = line, .kind = EdgeKind::kLost};
    return true;
  }

  /// Waits for a run of scans, at most `most` of them.  Returns the number of the first scan not due yet.
  std::int64_t wait(std::size_t most) const {
    if (!pace_) return scans_;
    const double run = std::clamp(kRun_s * pace_->rate() * rate_hz_, 1.0, static_cast<double>(most));
    const double until_s =
        std::min(static_cast<double>(device_.next()) + std::floor(run) - 1.0, static_cast<double>(scans_)) /
        rate_hz_;
    const WallTime now = WallClock::now();
    std::this_thread::sleep_until(std::min(pace_->wall(until_s), now + kLongestWait));
    return static_cast<std::int64_t>(std::floor(pace_->drive_s(WallClock::now()) * rate_hz_)) + 1;
  }

  Device device_;
  double rate_hz_;
  std::int64_t scans_;      ///< of the whole drive
  std::int64_t first_ = 0;  ///< delivered first
  std::optional<Pace> pace_;
  ClockError clock_;
  std::optional<Scan> taken_;  ///< taken, but its edges are not all handed over
  MachineClock::duration slept_{};
  std::int64_t wakes_at_ = 0;  ///< number of the first scan behind the last sleep
};

}  // namespace

std::unique_ptr<FrontEnd> open_sim_front_end(const FrontEndRequest& request) {
  const WallTime opened = WallClock::now();
  const Address address = Address::parse(request.address);
  Scenario scenario = Scenario::read(address.scenario_path, request.vehicle, address.seed);
  if (address.seconds) scenario.scale_to(*address.seconds);
  std::optional<Pace> pace;
  if (address.rate) {
    const MachineClock::duration slept = MachineClock::slept();
    const WallTime start =
        address.start_ns ? WallTime(std::chrono::nanoseconds(*address.start_ns) - slept) : opened;
    pace.emplace(*address.rate, start, *address.rate == 1.0 ? std::optional(slept) : std::nullopt);
  }
  const double rate_hz = request.node.rate_hz * (1.0 + 1e-6 * address.converter_ppm);
  Device device(scenario, scenario.seed, request.vehicle, request.node, rate_hz);
  return std::make_unique<SimFrontEnd>(std::move(device), rate_hz, scenario.seconds(), pace, address.from_s,
                                       ClockError{address.clock_offset_s, 1e-6 * address.clock_ppm});
}

}  // namespace roadbalance::sim

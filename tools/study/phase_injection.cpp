#include "tools/study/phase_injection.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>

#include "common/bus/codec.hpp"
#include "firmware/pack.hpp"
#include "sim/conditioner.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr double kLearn_s = 2.0, kSeconds = 10.0;
constexpr double kAmplitude_m_s2 = 10.0;
constexpr double kAllowed_deg = 0.05;

/// A node with one acceleration on the front left carrier, and that wheel's encoder.
VehicleConfig bench(const PhaseInjection& injection) {
  VehicleConfig vehicle{};
  vehicle.name = "bench";
  vehicle.filter = injection.filter;
  for (std::size_t w = 0; w < kWheels; ++w) vehicle.wheel[w].name = kWheelNames[w];
  vehicle.wheel[0].node = "bench";
  vehicle.wheel[0].encoder = {.pulses_per_turn = 96};
  ChannelConfig channel;
  channel.name = "sine";
  channel.mount = kWheelNames[0];
  channel.range_m_s2 = 100.0;
  channel.scale_m_s2_per_count = 100.0 / kFullScaleCounts;
  vehicle.node.push_back({.name = "bench", .id = 1, .rate_hz = injection.scan_rate_hz, .channel = {channel}});
  vehicle.text = "# bench\n";
  return vehicle;
}

/// A noiseless car, of which the conditioner knows its sensors only.
sim::Scenario silent() {
  sim::Scenario scenario{};
  scenario.sensor = {};
  return scenario;
}

std::vector<Scan> converted(const PhaseInjection& injection, const VehicleConfig& vehicle,
                            const std::function<double(double)>& angle_rad) {
  const double step_s = 0.5 / injection.scan_rate_hz;
  sim::Conditioner conditioner(silent(), 1, vehicle, vehicle.node[0], step_s);
  std::vector<Scan> scans(static_cast<std::size_t>(kSeconds * injection.scan_rate_hz));
  sim::SourceVector sources = sim::SourceVector::Zero();
  std::int64_t step = 0;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    for (; step <= 2 * static_cast<std::int64_t>(k); ++step) {
      sources(sim::kCoordinateSource + kBodyCoordinates) =
          kAmplitude_m_s2 * std::cos(angle_rad(static_cast<double>(step) * step_s - injection.sine_late_s) -
                                     injection.phase_rad);
      conditioner.feed(sources, step);
    }
    scans[k].index = static_cast<std::int64_t>(k);
    scans[k].time = node_time_from_ns(std::llround(static_cast<double>(2 * k) * step_s * 1e9));
    conditioner.convert(scans[k]);
  }
  return scans;
}

/// Demodulates the channel of each block by channels 13 and 14, under a window that lets nothing of twice the
/// frequency pass.
class Demodulation final : public BlockSink {
 public:
  std::size_t room() const noexcept override { return std::numeric_limits<std::size_t>::max(); }
  SealedBlock* claim() noexcept override { return &block_; }
  void commit() noexcept override {
    if (block_.kind != BlockKind::kScan) return;
    const ScanBlock scans = decode_scan(block_);
    for (std::int64_t row = 0; row < scans.header.scans; ++row) {
      const double at =
          (static_cast<double>(scans.row_time_ns(row)) * 1e-9 - kLearn_s) / (kSeconds - kLearn_s);
      if (at <= 0.0 || at >= 1.0) continue;
      if ((scans.quality & kQualityNoReference0) != 0) ++unknown_;
      const auto& counts = scans.counts[static_cast<std::size_t>(row)];
      const std::complex<double> reference(counts[kAccelerations + 1], counts[kAccelerations]);
      sum_ += std::pow(std::sin(pi * at), 2) * static_cast<double>(counts[0]) * std::conj(reference);
    }
  }
  /// Phase behind the reference; no number if a reference was not known.
  double phase_rad() const {
    return unknown_ > 0 ? std::numeric_limits<double>::quiet_NaN() : -std::arg(sum_);
  }

 private:
  SealedBlock block_;
  std::complex<double> sum_;
  std::int64_t unknown_ = 0;
};

}  // namespace

double injected_phase_error_deg(const PhaseInjection& injection) {
  const VehicleConfig vehicle = bench(injection);
  const auto angle_rad = [&](double t) { return 2.0 * pi * injection.turns_hz * t + 1.0; };
  const sim::PulseTrain train{.angle_rad = angle_rad, .jitter_s = 1e-6};
  Demodulation demodulation;
  Sealer sealer(vehicle, vehicle.node[0], 1, demodulation, nullptr);
  sealer.start();
  sealer.add(converted(injection, vehicle, angle_rad), train.edges(0.0, kSeconds), false);
  sealer.device_ended();
  static_cast<void>(sealer.finish());  // this sink always takes it
  return std::remainder(demodulation.phase_rad() - injection.phase_rad, 2.0 * pi) * 180.0 / pi;
}

std::vector<nlohmann::ordered_json> phase_injection_rows() {
  std::vector<nlohmann::ordered_json> rows;
  for (int order = 4; order <= 8; ++order) {
    double square = 0.0, largest = 0.0;
    int count = 0, unknown = 0;
    for (const double cutoff_hz : {100.0, 150.0, 200.0, 300.0, 400.0})
      for (const double turns_hz : {5.0, 10.0, 18.0, 25.0}) {
        const double error = injected_phase_error_deg({.filter = {order, cutoff_hz}, .turns_hz = turns_hz});
        ++count;
        if (!std::isfinite(error)) {
          ++unknown;
          continue;
        }
        square += error * error;
        largest = std::max(largest, std::abs(error));
      }
    rows.push_back({{"case", "sine and pulses through a filter of order " + std::to_string(order)},
                    {"rms_deg", std::sqrt(square / count)},
                    {"max_deg", largest},
                    {"allowed_rms_deg", kAllowed_deg},
                    {"allowed_max_deg", kAllowed_deg},
                    {"unknown_blocks", unknown},
                    {"met", unknown == 0 && largest <= kAllowed_deg}});
  }
  return rows;
}

}  // namespace roadbalance

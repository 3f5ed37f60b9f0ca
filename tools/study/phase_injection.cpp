#include "tools/study/phase_injection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <optional>

#include "common/bus/codec.hpp"
#include "firmware/block_packer.hpp"
#include "sim/conditioner.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr double kLearn_s = 2.0, kInjection_s = 10.0, kMiddle_s = 0.5 * (kLearn_s + kInjection_s);
constexpr double kAmplitude_m_s2 = 10.0;
constexpr double kAllowedError_deg = 0.05, kAllowedShare = 0.001;
constexpr double kDrift_turns_s2 = 5.0 / 3.6 / 60.0 / (2.0 * std::numbers::pi * 0.3);  // 5 km/h a minute

/// Phase of the generator, in turns.
struct Motion {
  double turns_hz, drift_turns_s2;

  double speed(double t) const { return turns_hz + drift_turns_s2 * (t - kMiddle_s); }
  double angle_rad(double t) const {
    const double after_s = t - kMiddle_s;
    return 2.0 * pi * (turns_hz + 0.5 * drift_turns_s2 * after_s) * after_s + 1.0;
  }
};

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

/// A noiseless car, of which the conditioner gets the sensors only.
sim::Scenario silent() {
  sim::Scenario scenario{};
  scenario.sensor = {};
  return scenario;
}

std::vector<Scan> converted(const PhaseInjection& injection, const VehicleConfig& vehicle,
                            const Motion& motion) {
  const double step_s = 0.5 / injection.scan_rate_hz;
  sim::Conditioner conditioner(silent(), 1, vehicle, vehicle.node[0], step_s);
  std::vector<Scan> scans(static_cast<std::size_t>(kInjection_s * injection.scan_rate_hz));
  sim::SourceVector sources = sim::SourceVector::Zero();
  std::int64_t step = 0;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    for (; step <= 2 * static_cast<std::int64_t>(k); ++step) {
      const double speed = motion.speed(static_cast<double>(step) * step_s) / motion.speed(kMiddle_s);
      sources(sim::kCoordinateSource + kBodyCoordinates) =
          kAmplitude_m_s2 * speed * speed *
          std::cos(motion.angle_rad(static_cast<double>(step) * step_s - injection.sine_late_s) -
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
  /// @param mean_hz  demodulate by this frequency instead; nothing: by the reference
  explicit Demodulation(std::optional<double> mean_hz) : mean_hz_(mean_hz) {}

  std::size_t room() const noexcept override { return std::numeric_limits<std::size_t>::max(); }
  SealedBlock* claim() noexcept override { return &block_; }
  void commit() noexcept override {
    if (block_.kind != BlockKind::kScan) return;
    const ScanBlock scans = decode_scan(block_);
    for (std::int64_t row = 0; row < scans.header.scans; ++row) {
      const double t = static_cast<double>(scans.row_time_ns(row)) * 1e-9;
      const double at = (t - kLearn_s) / (kInjection_s - kLearn_s);
      if (at <= 0.0 || at >= 1.0) continue;
      if ((scans.quality & kQualityNoReference0) != 0) ++unknown_;
      const auto& counts = scans.counts[static_cast<std::size_t>(row)];
      std::complex<double> reference(counts[kAccelerations + 1], counts[kAccelerations]);
      if (first_s_ < 0.0)
        first_s_ = t;
      else
        turned_rad_ += std::arg(reference * std::conj(last_));
      last_s_ = t;
      last_ = reference;
      if (mean_hz_) reference = std::polar(std::abs(reference), 2.0 * pi * *mean_hz_ * (t - kMiddle_s) + 1.0);
      const double weight = std::pow(std::sin(pi * at), 2);
      sum_ += weight * static_cast<double>(counts[0]) * std::conj(reference);
      power_ += weight * std::norm(reference);
    }
  }
  /// Counts, of the phase before the reference.
  std::complex<double> phasor() const {
    if (unknown_ > 0) return std::numeric_limits<double>::quiet_NaN();
    return 2.0 * static_cast<double>(kFullScaleCounts) * sum_ / power_;
  }
  double mean_hz() const { return turned_rad_ / (2.0 * pi * (last_s_ - first_s_)); }

 private:
  const std::optional<double> mean_hz_;
  SealedBlock block_;
  std::complex<double> sum_, last_;
  double power_ = 0.0, turned_rad_ = 0.0, first_s_ = -1.0, last_s_ = 0.0;
  std::int64_t unknown_ = 0;
};

}  // namespace

std::complex<double> injected_over_sent(const PhaseInjection& injection, bool by_mean_speed) {
  const VehicleConfig vehicle = bench(injection);
  const Motion motion{injection.turns_hz, injection.drift_turns_s2};
  const sim::PulseTrain train{.angle_rad = [&](double t) { return motion.angle_rad(t); }, .jitter_s = 1e-6};
  Demodulation demodulation(by_mean_speed ? std::optional(injection.turns_hz) : std::nullopt);
  BlockPacker packer(vehicle, vehicle.node[0], 1, demodulation, nullptr);
  packer.start();
  packer.add(converted(injection, vehicle, motion), train.edges(0.0, kInjection_s), false);
  packer.device_ended();
  static_cast<void>(packer.finish());  // this sink always takes it
  const double speed = demodulation.mean_hz() / injection.turns_hz;
  const double sent = kAmplitude_m_s2 / vehicle.node[0].channel[0].scale_m_s2_per_count;
  return demodulation.phasor() / (speed * speed) / std::polar(sent, -injection.phase_rad);
}

double injected_phase_error_deg(const PhaseInjection& injection) {
  return -std::arg(injected_over_sent(injection)) * 180.0 / pi;
}

namespace {

/// An unbalance while the speed drifts, against the same one at a constant speed.
nlohmann::ordered_json drift_row() {
  std::vector<double> errors_deg;
  double largest_share = 0.0;
  for (const double turns_hz : {10.0, 14.0, 18.0}) {
    PhaseInjection injection{.filter = {}, .turns_hz = turns_hz};
    const auto steady = injected_over_sent(injection);
    injection.drift_turns_s2 = kDrift_turns_s2;
    const auto cost = injected_over_sent(injection) / steady;
    errors_deg.push_back(std::arg(cost) * 180.0 / pi);
    largest_share = std::max(largest_share, std::abs(std::abs(cost) - 1.0));
  }
  auto row = phase_row("unbalance while the speed drifts by 5 km/h a minute", errors_deg);
  row["max_percent"] = 100.0 * largest_share;
  row["allowed_max_percent"] = 100.0 * kAllowedShare;
  row["met"] = row["met"].get<bool>() && largest_share <= kAllowedShare;
  return row;
}

}  // namespace

nlohmann::ordered_json phase_row(const std::string& name, const std::vector<double>& errors_deg) {
  double square = 0.0, largest = 0.0;
  int known = 0;
  for (const double error_deg : errors_deg) {
    if (!std::isfinite(error_deg)) continue;
    ++known;
    square += error_deg * error_deg;
    largest = std::max(largest, std::abs(error_deg));
  }
  const int unknown = static_cast<int>(std::ssize(errors_deg)) - known;
  return {{"case", name},
          {"rms_deg", std::sqrt(square / std::max(known, 1))},
          {"max_deg", largest},
          {"allowed_rms_deg", kAllowedError_deg},
          {"allowed_max_deg", kAllowedError_deg},
          {"unknown_blocks", unknown},
          {"met", known > 0 && unknown == 0 && largest <= kAllowedError_deg}};
}

std::vector<nlohmann::ordered_json> phase_injection_rows() {
  std::vector<nlohmann::ordered_json> rows;
  for (int order = 4; order <= 8; ++order) {
    std::vector<double> errors_deg;
    for (const double cutoff_hz : {100.0, 150.0, 200.0, 300.0, 400.0})
      for (const double turns_hz : {5.0, 10.0, 18.0, 25.0})
        errors_deg.push_back(injected_phase_error_deg({.filter = {order, cutoff_hz}, .turns_hz = turns_hz}));
    rows.push_back(
        phase_row("sine and pulses through a filter of order " + std::to_string(order), errors_deg));
  }
  rows.push_back(drift_row());
  return rows;
}

}  // namespace roadbalance

#include "host/orders/wheel_orders.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/dsp/decimation.hpp"
#include "host/orders/anti_aliasing.hpp"

namespace roadbalance {
namespace {

/// Of the sampling rate: so far FractionalDelay is a pure delay.
constexpr double kInterpolated = 0.38;
constexpr double kLeastReference = 0.5;  // of full scale; a known angle has nearly 1

double highest_hz(const VehicleConfig& vehicle, const NodeConfig& node) {
  return std::min(kInterpolated * node.rate_hz, AntiAliasing(vehicle.filter).flat_to_hz());
}

double class_hz(const VehicleConfig& vehicle, const WheelConfig& wheel) {
  return vehicle.drive.speed_class_m_s / (2.0 * std::numbers::pi * wheel.rolling_radius_m);
}

OrderVectors::Settings vector_settings(const VehicleConfig& vehicle, const WheelConfig& wheel, int channels,
                                       const std::vector<double>& order) {
  return {channels,
          WheelOrders::kRowsPerTurn,
          WheelOrders::kVectorTurns,
          order,
          highest_hz(vehicle, vehicle.node_named(wheel.node)),
          class_hz(vehicle, wheel),
          [filter = AntiAliasing(vehicle.filter)](double h, double rotation_hz) {
            return filter.on_order(h, rotation_hz);
          }};
}

}  // namespace

WheelOrders::WheelOrders(const VehicleConfig& vehicle, const WheelConfig& wheel,
                         std::vector<std::size_t> channel, std::vector<double> order)
    : wheel_(wheel),
      node_(vehicle.node_named(wheel.node)),
      channel_(std::move(channel)),
      order_(std::move(order)),
      waterfall_({static_cast<int>(channel_.size()), kRowsPerTurn, kSpectrumTurns,
                  kDecimationFlatTo * kRowsPerTurn, highest_hz(vehicle, node_), class_hz(vehicle, wheel)}),
      vectors_(vector_settings(vehicle, wheel, static_cast<int>(channel_.size()), order_)),
      spectrum_blocks_({static_cast<int>(channel_.size()), kRowsPerTurn, kSpectrumTurns, kSpectrumTurns / 4},
                       [this](const TurnBlock& block) { waterfall_.add(block); }),
      vector_blocks_({static_cast<int>(channel_.size()), kRowsPerTurn, kVectorTurns, kVectorTurns},
                     [this](const TurnBlock& block) { vectors_.add(block); }),
      resampler_({static_cast<int>(channel_.size()), node_.rate_hz, kRowsPerTurn, kLeastRotation_hz},
                 [this](const AngleRow& row) {
                   spectrum_blocks_.add(row);
                   vector_blocks_.add(row);
                 }),
      values_(std::ssize(channel_)) {}

void WheelOrders::consume(const SealedBlock& sealed) {
  if (sealed.kind != BlockKind::kScan || sealed.header.node != node_.id) return;
  if (sealed.header.epoch != epoch_ || sealed.header.first_scan != next_scan_) {
    if (next_scan_ >= 0) ++gaps_;
    resampler_.interrupt();
  }
  epoch_ = sealed.header.epoch;
  next_scan_ = sealed.header.first_scan + sealed.header.scans;
  scans_ += sealed.header.scans;
  add_rows(sealed);
}

void WheelOrders::add_rows(const SealedBlock& sealed) {
  const ScanBlock block = decode_scan(sealed);
  const int uncertain_bit = wheel_.line == 0 ? kQualityUncertainAngle0 : kQualityUncertainAngle1;
  const bool unknown = (block.quality & quality_no_reference(wheel_.line)) != 0;
  const bool uncertain = (block.quality & uncertain_bit) != 0;
  std::uint32_t overload = 0;
  for (std::size_t c = 0; c < channel_.size(); ++c)
    overload |= static_cast<std::uint32_t>(block.overload >> channel_[c] & 1) << c;
  for (std::int64_t row = 0; row < block.header.scans; ++row) {
    const auto& counts = block.counts[static_cast<std::size_t>(row)];
    const auto sine = static_cast<std::size_t>(kAccelerations + 2 * wheel_.line);
    const std::complex<double> reference(counts[sine + 1], counts[sine]);
    std::optional<double> angle_rad;
    if (unknown || std::abs(reference) < kLeastReference * kFullScaleCounts)
      ++no_angle_;
    else if (uncertain)
      ++uncertain_;
    else
      angle_rad = std::arg(reference);
    for (std::size_t c = 0; c < channel_.size(); ++c)
      values_(static_cast<Eigen::Index>(c)) = node_.channel[channel_[c]].to_si(counts[channel_[c]]);
    resampler_.add(angle_rad, values_, overload);
  }
}

WheelOrders::Seconds WheelOrders::seconds() const {
  const auto seconds = [&](std::int64_t scans) { return static_cast<double>(scans) / node_.rate_hz; };
  return {seconds(scans_), seconds(no_angle_), seconds(uncertain_), seconds(resampler_.slow_samples())};
}

}  // namespace roadbalance

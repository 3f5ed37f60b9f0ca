#pragma once

#include <memory>
#include <string>

#include "firmware/backends/socketcan/accelerometer_scans.hpp"
#include "firmware/backends/socketcan/can_decoder.hpp"
#include "firmware/backends/socketcan/can_intake.hpp"

namespace roadbalance {

/// The scans of an accelerometer module on a CAN interface, and the signals that come on the same one.
///
/// A module that gives no scan for two seconds while the interface is there counts as gone until the next
/// one, and the intake's thread is asked to report it, once for each silence.
class CanAccelerometer final : public FrontEnd {
 public:
  CanAccelerometer(std::unique_ptr<CanIntake> intake, CanDecoder decoder, const CanConfig& can);

  /// That no scan comes, and what may be why.
  static std::string silence(const CanConfig& can);

  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept override;
  ScanStamps scan_stamps() const noexcept override { return ScanStamps::kReadOut; }
  std::vector<const DeviceReport*> reports() const override { return {&intake_->report()}; }

 private:
  void take(const CanArrival& arrival, std::span<Scan> scans, std::span<SignalSample> signals,
            Read& read) noexcept;
  void listen_for_silence(bool any_scan, NodeTime complete) noexcept;

  const std::unique_ptr<CanIntake> intake_;
  const CanDecoder decoder_;
  const std::uint32_t first_id_;
  AccelerometerScans scans_;
  NodeTime heard_;  ///< a scan, or that the interface is gone
  bool silence_reported_ = false;
  bool module_gone_ = false;  ///< is counted
};

}  // namespace roadbalance

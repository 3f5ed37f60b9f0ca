#pragma once

#include <memory>

#include "common/frontend/side_source.hpp"
#include "firmware/backends/socketcan/can_decoder.hpp"
#include "firmware/backends/socketcan/can_intake.hpp"

namespace roadbalance {

/// The signals of a CAN interface, beside the scans of another device.
class CanSignalSource final : public SideSource {
 public:
  CanSignalSource(std::unique_ptr<CanIntake> intake, CanDecoder decoder);

  SideRead take(std::span<Edge> edges, std::span<SignalSample> signals) noexcept override;
  std::vector<const DeviceReport*> reports() const override { return {&intake_->report()}; }

 private:
  const std::unique_ptr<CanIntake> intake_;
  const CanDecoder decoder_;
};

}  // namespace roadbalance

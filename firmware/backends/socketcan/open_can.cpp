#include "firmware/backends/socketcan/open_can.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "common/config/section.hpp"
#include "common/frontend/side_source.hpp"
#include "firmware/backends/socketcan/can_accelerometer.hpp"
#include "firmware/backends/socketcan/can_decoder.hpp"
#include "firmware/backends/socketcan/can_intake.hpp"

namespace roadbalance {
namespace {

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

CanSignalSource::CanSignalSource(std::unique_ptr<CanIntake> intake, CanDecoder decoder)
    : intake_(std::move(intake)), decoder_(std::move(decoder)) {}

SideRead CanSignalSource::take(std::span<Edge>, std::span<SignalSample> signals) noexcept {
  // Asked for first: a frame that comes meanwhile is of no harm.
  SideRead read{.complete_until = intake_->complete_until()};
  for (const CanArrival* next = intake_->front(); next; intake_->pop(), next = intake_->front()) {
    if (signals.size() - read.signals < CanDecoder::kMostOfOneFrame) {
      read.complete_until = std::min(read.complete_until, next->time);
      break;
    }
    read.signals +=
        decoder_.decode(next->frame, next->time, signals.subspan(read.signals), intake_->report());
  }
  return read;
}

const CanConfig& wiring_of(const FrontEndRequest& request) {
  const auto& all = request.node.wiring.can;
  const auto found = std::ranges::find(all, request.address, &CanConfig::interface);
  if (found != all.end()) return *found;
  throw ConfigError("front end \"can:" + request.address + "\": node " + request.node.name +
                    " has no [[node.can]] with interface = \"" + request.address + "\"");
}

/// The module's identifiers, after a check that it can be what it is wired as.
std::vector<CanId> module_ids(const CanConfig& can, const NodeConfig& node,
                              const std::vector<CanId>& others) {
  const std::string name = "accelerometer on " + can.interface + ": ";
  if (node.rate_hz != AccelerometerScans::kRateHz)
    throw ConfigError(name + "it converts 1000 times a second, but rate_hz of node " + node.name + " is " +
                      std::to_string(node.rate_hz));
  static_assert(kHighestAccelerometerId + AccelerometerFrame::kParts - 1 == kHighestStandardId);
  std::vector<CanId> ids;
  for (std::uint32_t part = 0; part < AccelerometerFrame::kParts; ++part) {
    ids.push_back({.id = *can.accelerometer_id + part});
    if (std::ranges::find(others, ids.back()) != others.end())
      throw ConfigError(name + "identifier " + std::to_string(ids.back().id) +
                        " is also that of a signal in " + can.dbc);
  }
  return ids;
}

}  // namespace

OpenedDevice open_can(const FrontEndRequest& request, const CanIntake::Warn& warn) {
  const CanConfig& can = wiring_of(request);
  CanDecoder decoder;
  if (!can.signal.empty())
    decoder = CanDecoder(can, request.vehicle,
                         Dbc::read_file((std::filesystem::path(request.vehicle.folder) / can.dbc).string()));
  std::vector<CanId> wanted = decoder.ids();
  if (can.accelerometer_id)
    for (const CanId& id : module_ids(can, request.node, wanted)) wanted.push_back(id);
  if (wanted.empty())
    throw ConfigError("front end \"can:" + can.interface +
                      "\": nothing is wanted of it; allowed: [[node.can.signal]], accelerometer_id");
  auto intake =
      std::make_unique<CanIntake>(can.interface, CanNeed{.role = can.role, .fd = decoder.needs_fd()},
                                  std::move(wanted), warn, [can] { return CanAccelerometer::silence(can); });
  if (can.accelerometer_id)
    return std::make_unique<CanAccelerometer>(std::move(intake), std::move(decoder), can);
  return std::make_unique<CanSignalSource>(std::move(intake), std::move(decoder));
}

}  // namespace roadbalance

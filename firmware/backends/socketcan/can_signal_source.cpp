#include "firmware/backends/socketcan/can_signal_source.hpp"

#include <utility>

namespace roadbalance {

CanSignalSource::CanSignalSource(std::unique_ptr<CanIntake> intake, CanDecoder decoder)
    : intake_(std::move(intake)), decoder_(std::move(decoder)) {}

SideRead CanSignalSource::take(std::span<Edge>, std::span<SignalSample> signals) noexcept {
  // Asked for first: a frame that comes meanwhile is of no harm.
  SideRead read{.complete_until = intake_->complete_until()};
  for (std::size_t waiting = intake_->size(); waiting > 0; --waiting, intake_->drop(1)) {
    const CanArrival& arrival = (*intake_)[0];
    if (signals.size() - read.signals < CanDecoder::kMostOfOneFrame) {
      read.complete_until = std::min(read.complete_until, arrival.time);
      break;
    }
    const auto decoded = decoder_.decode(arrival.frame, arrival.time, signals.subspan(read.signals));
    read.signals += decoded.samples;
    if (decoded.refused) intake_->report().count(DeviceCounter::kFramesRefused);
  }
  return read;
}

}  // namespace roadbalance

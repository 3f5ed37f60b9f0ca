#include "firmware/backends/socketcan/can_signal_source.hpp"

#include <utility>

namespace roadbalance {

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

}  // namespace roadbalance

#include "firmware/backends/socketcan/can_accelerometer.hpp"

#include <utility>

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kLongestRead{100};

}  // namespace

CanAccelerometer::CanAccelerometer(std::unique_ptr<CanIntake> intake, CanDecoder decoder,
                                   std::uint32_t first_id)
    : intake_(std::move(intake)), decoder_(std::move(decoder)), first_id_(first_id) {}

Read CanAccelerometer::read(std::span<Scan> scans, std::span<Edge>,
                            std::span<SignalSample> signals) noexcept {
  Read read;
  const std::int64_t missing = scans_.missing();
  const std::int64_t repeated = scans_.repeated();
  const WallTime until = WallClock::now() + kLongestRead;
  do {
    intake_->wait_until(until);
    for (const CanArrival* next = intake_->front(); next && read.scans < scans.size();
         next = intake_->front()) {
      if (signals.size() - read.signals < CanDecoder::kMostOfOneFrame) break;
      take(*next, scans, signals, read);
      intake_->pop();
    }
  } while (read.scans == 0 && read.signals == 0 && WallClock::now() < until);
  DeviceReport& report = intake_->report();
  report.count(DeviceCounter::kPacketsMissing, scans_.missing() - missing);
  report.count(DeviceCounter::kPacketsRefused, scans_.repeated() - repeated);
  return read;
}

void CanAccelerometer::take(const CanArrival& arrival, std::span<Scan> scans, std::span<SignalSample> signals,
                            Read& read) noexcept {
  DeviceReport& report = intake_->report();
  const std::uint32_t place = arrival.frame.id - first_id_;
  if (arrival.frame.extended || place >= AccelerometerFrame::kParts) {
    read.signals += decoder_.decode(arrival.frame, arrival.time, signals.subspan(read.signals), report);
    return;
  }
  const auto said = read_accelerometer(arrival.frame, first_id_);
  if (!said) return report.count(DeviceCounter::kFramesRefused);
  if (const auto scan = scans_.add(*said, arrival.time, arrival.after_absence)) scans[read.scans++] = *scan;
}

}  // namespace roadbalance

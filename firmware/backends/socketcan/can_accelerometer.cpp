#include "firmware/backends/socketcan/can_accelerometer.hpp"

#include <array>
#include <cstdio>
#include <utility>

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kLongestRead{100};
constexpr std::chrono::seconds kLongestSilence{2};

}  // namespace

CanAccelerometer::CanAccelerometer(std::unique_ptr<CanIntake> intake, CanDecoder decoder,
                                   const CanConfig& can)
    : intake_(std::move(intake)),
      decoder_(std::move(decoder)),
      first_id_(can.accelerometer_id.value()),
      heard_(intake_->complete_until()) {}

Read CanAccelerometer::read(std::span<Scan> scans, std::span<Edge>,
                            std::span<SignalSample> signals) noexcept {
  Read read;
  const std::int64_t missing = scans_.missing();
  const std::int64_t repeated = scans_.repeated();
  const NodeTime complete = intake_->complete_until();  // before the queue is looked into
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
  listen_for_silence(read.scans > 0, complete);
  return read;
}

/// By the time line of the stamps: a node that was not scheduled does not take it for the module's silence.
/// @param complete  all frames stamped before have been taken, if the queue is empty
void CanAccelerometer::listen_for_silence(bool any_scan, NodeTime complete) noexcept {
  if (any_scan || intake_->gone()) {
    heard_ = complete;
    silence_reported_ = false;
  } else if (!silence_reported_ && !intake_->front() && complete - heard_ > kLongestSilence) {
    silence_reported_ = true;
    intake_->report_silence();
    if (!std::exchange(module_gone_, true)) intake_->report().count(DeviceCounter::kGone);
  }
}

std::string CanAccelerometer::silence(const CanConfig& can) {
  const std::uint32_t first = can.accelerometer_id.value();
  std::array<char, 80> ids{};
  std::snprintf(ids.data(), ids.size(),
                "no scan of the accelerometer module comes (identifiers 0x%X to 0x%X)", first,
                first + AccelerometerFrame::kParts - 1);
  std::string text = "can:" + can.interface + ": " + ids.data();
  const auto link = query_can_link(can.interface.c_str());
  if (link && !link->takes_fd)
    text += "; " + can.interface + " carries no CAN FD, in case the module sends that";
  return text;
}

void CanAccelerometer::take(const CanArrival& arrival, std::span<Scan> scans, std::span<SignalSample> signals,
                            Read& read) noexcept {
  DeviceReport& report = intake_->report();
  const std::uint32_t place = arrival.frame.id - first_id_;
  if (arrival.frame.extended || place >= AccelerometerFrame::kParts) {
    read.signals += decoder_.decode(arrival.frame, arrival.time, signals.subspan(read.signals), report);
    return;
  }
  const auto content = read_accelerometer(arrival.frame, first_id_);
  if (!content) return report.count(DeviceCounter::kFramesRefused);
  const auto scan = scans_.add(*content, arrival.time, arrival.after_absence || module_gone_);
  if (!scan) return;
  scans[read.scans++] = *scan;
  if (std::exchange(module_gone_, false)) report.count(DeviceCounter::kReturned);
}

}  // namespace roadbalance

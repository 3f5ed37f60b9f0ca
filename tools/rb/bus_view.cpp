#include "tools/rb/bus_view.hpp"

#include <algorithm>
#include <span>
#include <string_view>

namespace roadbalance {

BusView::BusView(const std::string& url) : bus_(url) {
  using Bytes = std::span<const std::uint8_t>;
  bus_.subscribe(kLevelChannel, [this](std::string_view, Bytes bytes) {
    if (const auto level = decode_level(bytes)) levels_[level->node] = *level;
  });
  bus_.subscribe(kSpectrumChannel, [this](std::string_view, Bytes bytes) {
    if (const auto part = decode_spectrum(bytes)) take(*part);
  });
  bus_.subscribe(kIdentificationChannel, [this](std::string_view, Bytes bytes) {
    if (const auto message = decode_identification(bytes)) identification_ = *message;
  });
  bus_.subscribe(kBalanceChannel, [this](std::string_view, Bytes bytes) {
    const auto message = decode_balance(bytes);
    if (!message || message->wheel < 0 || message->wheel >= kWheels) return;
    auto& last = balance_[static_cast<std::size_t>(message->wheel)];
    // The wheels of an estimate come one after the other.
    news_ = news_ || (message->wheel == kWheels - 1 && (!last || last->time_ns != message->time_ns));
    last = *message;
  });
  bus_.subscribe(kRecorderChannel, [this](std::string_view, Bytes bytes) {
    if (const auto status = decode_recorder_status(bytes)) take(*status);
  });
  bus_.subscribe("RB_HEARTBEAT_.*", [this](std::string_view, Bytes bytes) {
    if (const auto beat = decode_heartbeat(bytes)) heartbeats_[beat->node] = *beat;
  });
}

// What comes from the bus is bounded.
void BusView::take(const RecorderStatus& status) {
  constexpr std::size_t kMostRecorders = 8;
  if (!recorders_.contains(status.incarnation) && recorders_.size() >= kMostRecorders) return;
  recorders_[status.incarnation] = status;
  recorder_heard_at_[status.incarnation] = WallClock::now();
}

// It says its state twice a second.
void BusView::forget_silent_recorders() {
  static constexpr std::chrono::seconds kSilence{3};
  std::erase_if(recorders_, [this](const auto& recorder) {
    return WallClock::now() - recorder_heard_at_[recorder.first] > kSilence;
  });
  std::erase_if(recorder_heard_at_, [this](const auto& heard) { return !recorders_.contains(heard.first); });
}

void BusView::take(const SpectrumPart& part) {
  constexpr double kLowest_hz = 2.0;  // a mean value is no line
  Line& line = lines_[{part.node, part.channel}];
  if (part.part == 0) line = {};
  for (std::size_t bin = 0; bin < part.density.size(); ++bin) {
    const double frequency_hz = part.first_hz + part.step_hz * static_cast<double>(bin);
    if (frequency_hz >= kLowest_hz && part.density[bin] > line.density)
      line = {frequency_hz, part.density[bin]};
  }
}

bool BusView::handle(std::chrono::milliseconds timeout) {
  news_ = false;
  bus_.handle(timeout);
  forget_silent_recorders();
  return news_;
}

}  // namespace roadbalance

#include "tools/views/bus_view.hpp"

#include <algorithm>
#include <bitset>
#include <span>
#include <string_view>
#include <tuple>

#include "common/bus/clock_messages.hpp"

namespace roadbalance {
namespace {

// Values whose change belongs into a log.
auto state_of(const Heartbeat& beat) {
  std::bitset<kDeviceCounters> suffers;
  for (std::size_t k = 0; k < kDeviceCounters; ++k) suffers[k] = beat.device_counts[k] != 0;
  const auto count = [&](DeviceCounter c) { return beat.device_counts[static_cast<std::size_t>(c)]; };
  return std::tuple(beat.epoch, beat.state, beat.owner, beat.spool_used > 0, beat.spool_failures,
                    beat.scans_missing > 0, beat.time_base, suffers, count(DeviceCounter::kGone),
                    count(DeviceCounter::kReturned));
}

auto state_of(const RecorderStatus& status) {
  return std::tuple(status.state, status.on_battery, status.fallback, status.segment, status.disk_failures,
                    status.rivals > 0);
}

auto state_of(const ClockFit& fit) {
  return std::tuple(fit.epoch, fit.state, fit.breaks);
}

// True if its state is new.
template <typename Key, typename Message>
bool put(std::map<Key, Message>& known, Key key, const Message& message) {
  const auto [place, is_new] = known.try_emplace(key, message);
  const bool changed = is_new || state_of(place->second) != state_of(message);
  place->second = message;
  return changed;
}

}  // namespace

BusView::BusView(const std::string& url) : bus_(url) {
  using Bytes = std::span<const std::uint8_t>;
  bus_.subscribe(kLevelChannel, [this](std::string_view, Bytes bytes) {
    const auto level = decode_level(bytes);
    if (!level) return;
    if (levels_.contains(level->node) || levels_.size() < kMostNodes) levels_[level->node] = *level;
    watch_.take(*level, WallClock::now());
  });
  bus_.subscribe(kSpectrumChannel, [this](std::string_view, Bytes bytes) {
    if (const auto part = decode_spectrum(bytes)) take(*part);
  });
  bus_.subscribe(kOrdersChannel, [this](std::string_view, Bytes bytes) {
    if (const auto report = decode_orders(bytes)) take(*report);
  });
  bus_.subscribe(kIdentificationChannel, [this](std::string_view, Bytes bytes) {
    if (const auto message = decode_identification(bytes)) identification_ = *message;
  });
  bus_.subscribe(kCompensationChannel, [this](std::string_view, Bytes bytes) {
    if (const auto message = decode_compensation(bytes))
      compensation_[static_cast<std::size_t>(message->wheel)] = *message;
  });
  bus_.subscribe(kBalanceChannel, [this](std::string_view, Bytes bytes) {
    const auto message = decode_balance(bytes);
    if (!message || message->wheel < 0 || message->wheel >= kWheels) return;
    watch_.take(*message, WallClock::now());
    auto& last = balance_[static_cast<std::size_t>(message->wheel)];
    // The wheels of an estimate come one after the other.
    news_ = news_ || (message->wheel == kWheels - 1 && (!last || last->time_ns != message->time_ns));
    last = *message;
  });
  bus_.subscribe(kRemarkChannel, [this](std::string_view, Bytes bytes) {
    if (const auto remark = decode_remark(bytes)) remarks_[remark->number] = *remark;
  });
  bus_.subscribe(kWeightCheckChannel, [this](std::string_view, Bytes bytes) {
    if (const auto wheel = decode_weight_check(bytes))
      weight_check_[static_cast<std::size_t>(wheel->wheel)] = *wheel;
  });
  bus_.subscribe(kRecorderChannel, [this](std::string_view, Bytes bytes) {
    if (const auto status = decode_recorder_status(bytes)) take(*status);
  });
  bus_.subscribe("RB_HEARTBEAT_.*", [this](std::string_view, Bytes bytes) {
    if (const auto beat = decode_heartbeat(bytes)) take(*beat);
  });
  bus_.subscribe("RB_CLOCK_.*", [this](std::string_view, Bytes bytes) {
    if (const auto fit = decode_clock_fit(bytes)) take(*fit);
  });
}

Compensation BusView::compensation(std::size_t wheel) const {
  const auto& found = compensation_[wheel];
  const auto& of = balance_[wheel];
  if (found && of && found->time_ns == of->time_ns) return *found;
  return {.wheel = static_cast<std::int32_t>(wheel)};
}

std::vector<std::string> BusView::remarks() const {
  std::vector<std::string> sentences;
  const auto first = remarks_.find(0);
  if (first == remarks_.end()) return sentences;
  for (const auto& [number, remark] : remarks_)
    if (number < first->second.remarks && remark.time_ns == first->second.time_ns)
      sentences.push_back(remark.text);
  return sentences;
}

// Input from the bus is bounded.
void BusView::take(const OrderReport& report) {
  constexpr std::size_t kMost = kMostNodes * kWheels;
  const std::pair key(report.wheel, report.node);
  if (orders_.contains(key) || orders_.size() < kMost) orders_[key] = report;
}

void BusView::take(const RecorderStatus& status) {
  constexpr std::size_t kMostRecorders = 8;
  if (!recorders_.contains(status.recorder) && recorders_.size() >= kMostRecorders) return;
  state_changed_ = put(recorders_, status.recorder, status) || state_changed_;
  recorder_heard_at_[status.recorder] = WallClock::now();
}

void BusView::take(const Heartbeat& beat) {
  state_changed_ = put(heartbeats_, beat.node, beat) || state_changed_;
  sealing_[beat.node].take(beat);
  watch_.take(beat, WallClock::now());
}

void BusView::take(const ClockFit& fit) {
  state_changed_ = put(clocks_, fit.node, fit) || state_changed_;
  watch_.take(fit, WallClock::now());
}

std::optional<double> BusView::memory_left_s(std::int32_t node) const {
  const auto rate = sealing_.find(node);
  return rate == sealing_.end() ? std::nullopt : rate->second.seconds_left(heartbeats_.at(node));
}

// It sends its state twice a second.
void BusView::forget_silent_recorders() {
  static constexpr std::chrono::seconds kSilence{3};
  const auto gone = std::erase_if(recorders_, [this](const auto& recorder) {
    return WallClock::now() - recorder_heard_at_[recorder.first] > kSilence;
  });
  state_changed_ = state_changed_ || gone > 0;
  std::erase_if(recorder_heard_at_, [this](const auto& heard) { return !recorders_.contains(heard.first); });
}

void BusView::take(const SpectrumPart& part) {
  if (part.viewer != 0) return;       // with another viewer's window and average
  constexpr double kLowest_hz = 2.0;  // a mean value is no line
  constexpr std::size_t kMost = kMostNodes * kChannels;
  const std::pair key(part.node, part.channel);
  if (!lines_.contains(key) && lines_.size() >= kMost) return;
  Line& line = lines_[key];
  if (part.part == 0) line = {};
  for (std::size_t bin = 0; bin < part.density.size(); ++bin) {
    const double frequency_hz = part.first_hz + part.step_hz * static_cast<double>(bin);
    if (frequency_hz >= kLowest_hz && part.density[bin] > line.density)
      line = {frequency_hz, part.density[bin]};
  }
}

bool BusView::handle(std::chrono::milliseconds timeout) {
  news_ = false;
  state_changed_ = false;
  bus_.handle(timeout);
  forget_silent_recorders();
  const WallTime now = WallClock::now();
  watch_.turn(now);
  for (const std::int32_t node : bus_.nodes_of_other_versions()) watch_.take_other_version(node, now);
  // One that begins or ends is news for a log.
  state_changed_ = !watch_.due(now).empty() || state_changed_;
  return news_;
}

}  // namespace roadbalance

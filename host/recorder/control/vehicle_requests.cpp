#include "host/recorder/control/vehicle_requests.hpp"

#include <exception>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"

namespace roadbalance {

SessionState VehicleRequests::begin(const std::filesystem::path& vehicle,
                                    const std::filesystem::path& recordings, std::uint64_t seed, Disk& disk,
                                    SessionState state, std::int64_t utc_us, WallTime now,
                                    const RecordingsFolder::Warn& warn) {
  const bool is_under_way = state.set_up && state.set_up->state == AnswerState::kUnderWay;
  if (vehicle.empty()) {
    if (is_under_way) {
      state.set_up->state = AnswerState::kRefused;
      state.set_up->reason = RefusalReason::kNotSupported;
      state.set_up->text = no_set_up_;
    }
    return state;
  }
  try {
    set_up_.emplace(vehicle, recordings, seed, disk);
    if (is_under_way) set_up_->resume(*state.set_up, utc_us, now);
  } catch (const std::exception& error) {
    if (!state.active) throw;
    set_up_.reset();
    no_set_up_ = error.what() + std::string(": mend the file and start rb-recorder again");
    warn("goes on without its vehicle file: " + no_set_up_);
  }
  return state;
}

void VehicleRequests::take(std::string_view channel, std::span<const std::uint8_t> bytes, WallTime now) {
  if (set_up_ && channel.starts_with("RB_REPLY_")) {
    if (const auto reply = decode_reply(bytes)) set_up_->take(*reply);
  } else if (set_up_ && channel.starts_with("RB_PREVIEW_")) {
    if (accept(bytes, block_) == Refusal::kNone && block_.kind == BlockKind::kScan)
      set_up_->take(decode_scan(block_), now);
  } else if (mark_readings_.listens() && channel.starts_with(kBlockChannels)) {
    if (accept(bytes, block_) == Refusal::kNone) mark_readings_.take(block_, now);
  }
}

Answer VehicleRequests::set_up(const Request& request, const std::vector<std::int32_t>& nodes,
                               std::int64_t utc_us, WallTime now) {
  if (set_up_) return set_up_->take(request, nodes, utc_us, now);
  return no_vehicle(request, utc_us);
}

Answer VehicleRequests::read_mark(const Request& request, std::int64_t utc_us, WallTime now) {
  if (set_up_) return mark_readings_.take(request, set_up_->vehicle(), now);
  return no_vehicle(request, utc_us);
}

Answer VehicleRequests::no_vehicle(const Request& request, std::int64_t utc_us) const {
  Answer answer = answer_to(request, utc_us);
  answer.state = AnswerState::kRefused;
  answer.reason = RefusalReason::kNotSupported;
  answer.text = no_set_up_;
  return answer;
}

std::optional<Answer> VehicleRequests::turn(const Publish& publish, std::int64_t utc_us, WallTime now) {
  return set_up_ ? set_up_->turn(publish, utc_us, now) : std::nullopt;
}

}  // namespace roadbalance

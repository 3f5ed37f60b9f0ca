#include "firmware/board/control.hpp"

#include <algorithm>

namespace roadbalance::board {
namespace {

constexpr std::uint16_t kFewestPulses = 4;
constexpr std::uint32_t kCornerMinMhz = 100;
constexpr std::uint32_t kCornerMaxMhz = 200'000;
constexpr std::uint16_t kPerMille = 1000;

bool is_possible(const EncoderSetup& encoder) {
  if (encoder.pulses_per_turn == 0) return encoder.flags == 0;
  return encoder.pulses_per_turn >= kFewestPulses && (encoder.flags & ~kEncoderFlags) == 0;
}

bool is_possible(const ReferenceWheel& wheel) {
  return wheel.on <= 1 && wheel.line < kLines && wheel.amplitude_per_mille >= 1 &&
         wheel.amplitude_per_mille <= kPerMille && wheel.corner_mhz >= kCornerMinMhz &&
         wheel.corner_mhz <= kCornerMaxMhz;
}

bool has_filter(const Identity& identity, const Configuration& wanted) {
  if (wanted.filter_order >= 32 || (identity.filter_orders >> wanted.filter_order & 1) == 0) return false;
  if (wanted.filter_order == 0) return wanted.filter_corner_hz == 0;
  return wanted.filter_corner_hz >= identity.filter_min_hz &&
         wanted.filter_corner_hz <= identity.filter_max_hz;
}

template <std::size_t kBytes>
Control::Answer replied(const std::array<std::uint8_t, kBytes>& bytes, std::uint16_t length,
                        std::span<std::uint8_t> reply) {
  const std::size_t size = std::min({kBytes, std::size_t{length}, reply.size()});
  std::copy_n(bytes.begin(), size, reply.begin());
  return {.reply = size};
}

}  // namespace

Control::Answer Control::handle(const SetupPacket& setup, std::span<const std::uint8_t> data,
                                const Status& counters, std::span<std::uint8_t> reply) {
  Answer answer{.refusal = Refusal::kUnknownRequest};
  if (setup.value == 0 && setup.index == 0) {
    if (setup.request_type == kVendorIn) answer = answer_in(setup, counters, reply);
    if (setup.request_type == kVendorOut) answer = take_out(setup, data);
  }
  if (answer.refusal != Refusal::kNone) {
    ++refusals_;
    last_refusal_ = answer.refusal;
    refused_request_ = setup.request;
  }
  return answer;
}

Control::Answer Control::answer_in(const SetupPacket& setup, const Status& counters,
                                   std::span<std::uint8_t> reply) const {
  switch (static_cast<Request>(setup.request)) {
    case Request::kIdentify:
      return replied(encode(identity_), setup.length, reply);
    case Request::kConfiguration:
      if (!configured_) return {.refusal = Refusal::kWrongState};
      return replied(encode(configuration_), setup.length, reply);
    case Request::kStatus: {
      Status status = counters;
      status.state = state();
      status.last_refusal = last_refusal_;
      status.refused_request = refused_request_;
      status.refusals = refusals_;
      status.configured = configured_ ? 1 : 0;
      status.token = armed_.token;
      return replied(encode(status), setup.length, reply);
    }
    default:
      return {.refusal = Refusal::kUnknownRequest};
  }
}

Control::Answer Control::take_out(const SetupPacket& setup, std::span<const std::uint8_t> data) {
  if (data.size() != setup.length) return {.refusal = Refusal::kWrongLength};
  switch (static_cast<Request>(setup.request)) {
    case Request::kConfigure:
      return {.refusal = configure(data)};
    case Request::kReferences:
      return {.refusal = set_references(data)};
    case Request::kTestPattern:
      return {.refusal = set_pattern(data)};
    case Request::kArm:
      return {.refusal = arm(data), .event = Event::kArmed};
    case Request::kStart:
      return {.refusal = start(data), .event = Event::kStarted};
    case Request::kStop:
      if (!data.empty()) return {.refusal = Refusal::kWrongLength};
      set_state(State::kIdle);
      return {.event = Event::kStopped};
    default:
      return {.refusal = Refusal::kUnknownRequest};
  }
}

Refusal Control::checked(const Configuration& wanted) const {
  const bool possible = wanted.ticks_per_scan >= identity_.tick_hz / identity_.rate_max_hz &&
                        wanted.ticks_per_scan <= identity_.tick_hz / identity_.rate_min_hz &&
                        wanted.packet_limit_us >= kPacketLimitMinUs &&
                        wanted.packet_limit_us <= kPacketLimitMaxUs && has_filter(identity_, wanted) &&
                        wanted.references_on <= 1 &&
                        std::all_of(wanted.range.begin(), wanted.range.end(),
                                    [](std::uint8_t range) { return range < kRanges; }) &&
                        std::all_of(wanted.encoder.begin(), wanted.encoder.end(),
                                    [](const EncoderSetup& encoder) { return is_possible(encoder); });
  return possible ? Refusal::kNone : Refusal::kOutOfRange;
}

Refusal Control::configure(std::span<const std::uint8_t> data) {
  const auto wanted = decode_configuration(data);
  if (!wanted) return Refusal::kWrongLength;
  if (state() != State::kIdle) return Refusal::kWrongState;
  if (const Refusal refusal = checked(*wanted); refusal != Refusal::kNone) return refusal;
  if (!hardware_.configure(*wanted)) return Refusal::kHardware;
  configuration_ = *wanted;
  configured_ = true;
  return Refusal::kNone;
}

Refusal Control::set_references(std::span<const std::uint8_t> data) {
  const auto wanted = decode_reference_setup(data);
  if (!wanted) return Refusal::kWrongLength;
  if (state() != State::kIdle) return Refusal::kWrongState;
  for (const ReferenceWheel& wheel : wanted->wheel)
    if (!is_possible(wheel)) return Refusal::kOutOfRange;
  references_ = *wanted;
  return Refusal::kNone;
}

Refusal Control::set_pattern(std::span<const std::uint8_t> data) {
  if (data.size() != TestPattern::kBytes) return Refusal::kWrongLength;
  const auto wanted = decode_test_pattern(data);
  if (!wanted) return Refusal::kOutOfRange;
  if (state() != State::kIdle) return Refusal::kWrongState;
  pattern_ = wanted->pattern;
  return Refusal::kNone;
}

Refusal Control::arm(std::span<const std::uint8_t> data) {
  if (data.size() != Arm::kBytes) return Refusal::kWrongLength;
  const auto wanted = decode_arm(data);
  if (!wanted) return Refusal::kOutOfRange;
  if (state() != State::kIdle || !configured_) return Refusal::kWrongState;
  // Only now both are known: a reference needs an encoder that is used.
  if (configuration_.references_on != 0)
    for (const ReferenceWheel& wheel : references_.wheel)
      if (wheel.on != 0 && configuration_.encoder[wheel.line].pulses_per_turn == 0)
        return Refusal::kOutOfRange;
  armed_ = *wanted;
  set_state(State::kArmed);
  return Refusal::kNone;
}

Refusal Control::start(std::span<const std::uint8_t> data) {
  const auto wanted = decode_start(data);
  if (!wanted) return Refusal::kWrongLength;
  if (state() != State::kArmed || armed_.mode == StartMode::kFollower) return Refusal::kWrongState;
  return wanted->token == armed_.token ? Refusal::kNone : Refusal::kWrongToken;
}

void Control::reset() {
  set_state(State::kIdle);
  configured_ = false;
  configuration_ = {};
  references_ = {};
  pattern_ = Pattern::kOff;
  armed_ = {};
}

}  // namespace roadbalance::board

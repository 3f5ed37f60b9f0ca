#include "common/bus/control_messages.hpp"
#include "common/bus/operation.hpp"
#include "hil_tests/fuzz/round_trip.hpp"
#include "hil_tests/fuzz/shown.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/sealing_rate.hpp"
#include "tools/views/watch_json.hpp"

namespace {

roadbalance::fuzz::Shown shown(const roadbalance::Heartbeat& beat) {
  roadbalance::SealingRate rate;
  rate.take({.node = beat.node, .epoch = beat.epoch});
  rate.take(beat);
  const auto left_s = rate.seconds_left(beat);
  return {{node_line(beat, left_s), device_line(beat)}, node_json(beat, left_s)};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  const std::span<const std::uint8_t> bytes(data, size);
  fuzz::check_message<Heartbeat>(bytes, decode_heartbeat);
  fuzz::check_message<Ack>(bytes, decode_ack);
  fuzz::check_message<Command>(bytes, decode_command);
  fuzz::check_message<Reply>(bytes, decode_reply);
  fuzz::check_message<VehiclePart>(bytes, decode_vehicle_part);
  fuzz::check_message<Request>(bytes, decode_request);
  fuzz::check_message<Answer>(bytes, decode_answer);
  fuzz::check_message<Receipt>(bytes, decode_receipt);
  fuzz::check_shown<Heartbeat>(bytes, decode_heartbeat, shown);
  if (const auto ack = decode_ack(fuzz::in_form(encode(Ack{}), bytes))) {
    fuzz::require(ack->missing.size() <= kMaxMissingRanges, "an ack asks for few ranges");
    fuzz::require(ack->durable <= ack->received, "nothing is durable that was not received");
  }
  return 0;
}

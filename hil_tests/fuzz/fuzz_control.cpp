#include "common/bus/control.hpp"
#include "common/bus/operation.hpp"
#include "hil_tests/fuzz/round_trip.hpp"

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
  if (const auto ack = decode_ack(fuzz::in_form(encode(Ack{}), bytes))) {
    fuzz::require(ack->missing.size() <= kMaxMissingRanges, "an ack asks for few ranges");
    fuzz::require(ack->durable <= ack->received, "nothing is durable that was not received");
  }
  return 0;
}

#include "common/bus/clock_messages.hpp"
#include "common/bus/notes.hpp"
#include "common/bus/recorder_status.hpp"
#include "hil_tests/fuzz/round_trip.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  const std::span<const std::uint8_t> bytes(data, size);
  fuzz::check_message<Journal>(bytes, decode_journal);
  fuzz::check_message<Note>(bytes, decode_note);
  fuzz::check_message<Commit>(bytes, decode_commit);
  fuzz::check_message<ClockExchange>(bytes, decode_clock_exchange);
  fuzz::check_message<ClockFit>(bytes, decode_clock_fit);
  fuzz::check_message<RecorderStatus>(bytes, decode_recorder_status);
  return 0;
}

#include "common/bus/clock_messages.hpp"
#include "common/bus/notes.hpp"
#include "common/bus/recorder_status.hpp"
#include "hil_tests/fuzz/round_trip.hpp"
#include "hil_tests/fuzz/shown.hpp"
#include "tools/views/clock_line.hpp"
#include "tools/views/watch_json.hpp"
#include "tools/views/watch_lines.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  const std::span<const std::uint8_t> bytes(data, size);
  fuzz::check_message<Journal>(bytes, decode_journal);
  fuzz::check_message<Note>(bytes, decode_note);
  fuzz::check_message<Commit>(bytes, decode_commit);
  fuzz::check_message<ClockExchange>(bytes, decode_clock_exchange);
  fuzz::check_message<ClockFit>(bytes, decode_clock_fit);
  fuzz::check_message<RecorderStatus>(bytes, decode_recorder_status);
  fuzz::check_shown<ClockFit>(bytes, decode_clock_fit, [](const ClockFit& fit) {
    return fuzz::Shown{{clock_line(fit)}, clock_json(fit)};
  });
  fuzz::check_shown<RecorderStatus>(bytes, decode_recorder_status, [](const RecorderStatus& status) {
    const Heartbeat other{.node = 1, .owner = 1};
    return fuzz::Shown{recorder_lines(status, {{other.node, other}}), recorder_json(status)};
  });
  fuzz::check_shown<Note>(bytes, decode_note, [](const Note& note) {
    return fuzz::Shown{{note.text}, note.text};
  });
  return 0;
}

#include <algorithm>
#include <string>

#include "common/config/section.hpp"
#include "common/dbc/candump.hpp"
#include "common/dbc/dbc.hpp"
#include "common/dbc/dbc_reading.hpp"
#include "hil_tests/fuzz/property.hpp"

namespace roadbalance {
namespace {

using fuzz::require;

fuzz::Reached signals("a signal"), frames("a logged frame");

/// A whole frame of the message with the fuzzer's bytes: each signal is read within its range, and what is
/// read is written and read again the same.
void check(const DbcMessage& message, const std::string& bytes) {
  CanFrame frame{.id = message.id, .extended = message.extended, .is_fd = true, .size = kLongestCanBytes};
  std::copy_n(bytes.begin(), std::min(bytes.size(), frame.data.size()), frame.data.begin());
  for (const DbcSignal& signal : message.signals) {
    require(signal.place.fits(message.size), "a signal lies in its message");
    require(signal.place.scale != 0.0 && signal.low <= signal.high, "scale and range can be used");
    const DbcReading reading = read_signal(message, signal, frame);
    if (message.size > frame.size)
      require(reading.status == DbcReading::Status::kTooShort, "a short frame is refused");
    if (reading.status != DbcReading::Status::kOk) continue;
    signals.count();
    CanFrame again = frame;
    require(signal.place.put_bits(signal.place.bits(frame).value(), again), "what was read can be written");
    require(again.data == frame.data, "and writing it changes nothing");
  }
  const std::size_t shorter = message.size > 0 ? std::min(message.size - 1, kLongestCanBytes) : 0;
  if (message.size == 0) return;
  frame.size = static_cast<std::uint8_t>(shorter);
  for (const DbcSignal& signal : message.signals)
    require(read_signal(message, signal, frame).status == DbcReading::Status::kTooShort,
            "a frame shorter than its message is refused");
}

}  // namespace
}  // namespace roadbalance

// A DBC file: refused with an error that names the file, or all its signals can be read from any frame.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (const auto logged = parse_candump(text)) {
    frames.count();
    require(is_can_size(logged->frame.size, logged->frame.is_fd), "a logged frame has a size there is");
  }
  try {
    const Dbc dbc = Dbc::parse(text, "fuzz.dbc");
    for (const DbcMessage& message : dbc.messages) {
      require(message.id <= (message.extended ? kHighestExtendedId : kHighestStandardId),
              "an identifier fits");
      require(dbc.message(message.name) == &message, "a name is unique");
      check(message, text);
    }
  } catch (const ConfigError& error) {
    require(std::string(error.what()).starts_with("fuzz.dbc:"), "an error names the file");
  }
  return 0;
}

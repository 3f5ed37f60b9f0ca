#include <stdexcept>
#include <string>

#include "common/bus/wire_text.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/recorder/control/session_state.hpp"

// The file in which a recorder that takes requests remembers them.
namespace roadbalance {
namespace {

using fuzz::require;
using test::SimulatedDisk;

constexpr const char* kFolder = "/recordings";

fuzz::Reached recordings("a recording under way"), ended("a recording that ended"), set_ups("a set-up"),
    pending("a pending epoch"), past("a past recording");

void count(const SessionState& state) {
  if (state.active) recordings.count();
  if (state.finished && !state.finished->receipt.empty()) ended.count();
  if (state.set_up) set_ups.count();
  if (!state.pending.empty()) pending.count();
  if (!state.past.empty()) past.count();
}

void check(const std::vector<std::uint8_t>& bytes) {
  const std::string file = std::string(kFolder) + "/" + kSessionStateFile;
  SimulatedDisk disk;
  disk.mkdir(kFolder, 0755);
  disk.put(file, bytes);
  SessionState state;
  try {
    state = read_session_state(kFolder, disk);
  } catch (const std::runtime_error& error) {
    const std::string_view said = error.what();
    require(said.starts_with(file + ": "), "a refusal names the file");
    require(wire_text::is_plain_text(said), "a refusal repeats nothing that a terminal would obey");
    require(disk.content(file) == bytes, "what is refused stays as it is");
    return;
  }
  count(state);
  if (state.active) require(fault_of_name(state.active->name).empty(), "a recording is a name");
  if (state.active) static_cast<void>(first_incarnation(*state.active, state.past));
  for (const PendingEpoch& one : state.pending)
    require(fault_of_name(one.recording).empty(), "so is that of a pending epoch");
  for (const PastRecording& one : state.past)
    require(fault_of_name(one.recording).empty(), "and that of a past one");
  write_session_state(kFolder, state, disk);
  const SessionState again = read_session_state(kFolder, disk);
  require(text_of(again) == text_of(state), "what was read is written so that it is read again alike");
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  roadbalance::check({data, data + size});
  return 0;
}

#include "host/recorder/control/session_state.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/bus/wire_text.hpp"
#include "common/frontend/front_end.hpp"
#include "common/record/folder.hpp"
#include "common/record/new_name.hpp"
#include "common/text/json_number.hpp"
#include "common/types/block.hpp"
#include "host/recorder/incarnation.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

// Bounds numbers that are added to: far from where an integer ends, as all are that a recorder writes.
constexpr std::int64_t kMostCounted = kRequestLimit - 1;
constexpr std::int32_t kMostMarks = 1'000'000'000;

// Reads the member by `read`; a refusal names it.
template <typename Read>
auto member(const Json& json, const char* key, Read read) {
  try {
    return read(json.at(key));
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string(key) + ": " + error.what());
  }
}

// Reads each element.
template <typename Read>
auto each(Read read) {
  return [read](const Json& json) {
    if (!json.is_array()) throw std::runtime_error("no array");
    std::vector<decltype(read(json))> all;
    for (const Json& one : json) all.push_back(read(one));
    return all;
  };
}

auto number_in(std::int32_t least, std::int32_t most) {
  return [least, most](const Json& json) { return small_number(json, least, most); };
}

template <typename Enum>
auto one_of(Enum first, Enum last) {
  return [first, last](const Json& json) {
    return static_cast<Enum>(
        small_number(json, static_cast<std::int32_t>(first), static_cast<std::int32_t>(last)));
  };
}

std::int64_t counted(const Json& json) {
  return whole_number(json, -kMostCounted, kMostCounted);
}

std::string text_in(const Json& json) {
  return json.get<std::string>();
}

std::string name_in(const Json& json) {
  auto name = text_in(json);
  if (const auto fault = fault_of_name(name); !fault.empty())
    throw std::runtime_error("no name of a recording: " + fault);
  return name;
}

Json to_json(const RequestKey& key) {
  return {key.asker, key.request};
}

RequestKey key_of(const Json& json) {
  return {counted(json.at(0)), counted(json.at(1))};
}

Json to_json(const std::deque<Mark>& marks) {
  Json json = Json::array();
  for (const Mark& mark : marks) json.push_back({mark.number, to_json(mark.asked), mark.text});
  return json;
}

Json to_json(const Absence& absence) {
  return {absence.node,       static_cast<int>(absence.cause),
          absence.since_us,   std::llround(1000.0 * absence.seconds),
          absence.from_begin, absence.to_end};
}

Absence absence_of(const Json& json) {
  return {.node = small_number(json.at(0), 1, kLastNode),
          .cause = one_of(AbsenceCause::kStopped, AbsenceCause::kNeverCame)(json.at(1)),
          .since_us = counted(json.at(2)),
          .seconds = 0.001 * static_cast<double>(counted(json.at(3))),
          .from_begin = json.at(4).get<bool>(),
          .to_end = json.at(5).get<bool>()};
}

Json to_json(const ActiveRecording& recording) {
  Json json = {{"name", recording.name},
               {"began_us", recording.began_us},
               {"start", to_json(recording.start)},
               {"marks", recording.marks},
               {"durable_marks", recording.durable_marks},
               {"mark", to_json(recording.mark)}};
  if (recording.clock_set_us != 0) json["clock_set_us"] = recording.clock_set_us;
  if (!recording.nodes.empty()) json["nodes"] = recording.nodes;
  if (!recording.missing.empty()) json["missing"] = recording.missing;
  for (const Absence& absence : recording.absence) json["absence"].push_back(to_json(absence));
  if (recording.stop) json["stop"] = to_json(*recording.stop);
  if (!recording.stopped_by.empty()) json["stopped_by"] = recording.stopped_by;
  return json;
}

Mark mark_of(const Json& json) {
  return {small_number(json.at(0), 0, kMostMarks), key_of(json.at(1)), text_in(json.at(2))};
}

std::deque<Mark> marks_of(const Json& json) {
  const auto marks = each(mark_of)(json);
  return {marks.begin(), marks.end()};
}

ActiveRecording active_of(const Json& json) {
  ActiveRecording recording{.name = member(json, "name", name_in),
                            .began_us = member(json, "began_us", counted),
                            .start = member(json, "start", key_of),
                            .marks = member(json, "marks", number_in(0, kMostMarks)),
                            .durable_marks = member(json, "durable_marks", number_in(0, kMostMarks)),
                            .mark = member(json, "mark", marks_of)};
  if (json.contains("clock_set_us")) recording.clock_set_us = member(json, "clock_set_us", counted);
  if (json.contains("nodes")) recording.nodes = member(json, "nodes", each(number_in(1, kLastNode)));
  if (json.contains("missing")) recording.missing = member(json, "missing", each(text_in));
  if (json.contains("absence")) recording.absence = member(json, "absence", each(absence_of));
  if (json.contains("stop")) recording.stop = member(json, "stop", key_of);
  if (json.contains("stopped_by")) recording.stopped_by = member(json, "stopped_by", text_in);
  return recording;
}

// Receipts as they go to the bus, in hexadecimal: one form of them is enough.
Json to_json(const Finished& finished) {
  constexpr const char* kDigits = "0123456789abcdef";
  Json receipts = Json::array();
  for (const Receipt& receipt : finished.receipt) {
    std::string text;
    for (const std::uint8_t byte : encode(receipt)) (text += kDigits[byte >> 4]) += kDigits[byte & 15];
    receipts.push_back(text);
  }
  return {{"start", to_json(finished.start)},
          {"stop", to_json(finished.stop)},
          {"receipt", receipts},
          {"durable_marks", finished.durable_marks},
          {"mark", to_json(finished.mark)}};
}

std::vector<std::uint8_t> bytes_in(const Json& json) {
  const std::string hexadecimal = text_in(json);
  std::vector<std::uint8_t> bytes(hexadecimal.size() / 2);
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    const char* const digits = hexadecimal.data() + 2 * k;
    if (std::from_chars(digits, digits + 2, bytes[k], 16).ptr != digits + 2)
      throw std::runtime_error("no hexadecimal digits");
  }
  if (hexadecimal.size() % 2 != 0) throw std::runtime_error("half a byte");
  return bytes;
}

// A receipt of another release is passed over: it only repeats what the record proves.
Finished finished_of(const Json& json) {
  Finished finished{.start = member(json, "start", key_of), .stop = member(json, "stop", key_of)};
  for (const auto& receipt : member(json, "receipt", each(bytes_in)))
    if (auto known = decode_receipt(receipt)) finished.receipt.push_back(std::move(*known));
  if (!json.contains("mark")) return finished;  // of an older release
  finished.durable_marks = member(json, "durable_marks", number_in(0, kMostMarks));
  finished.mark = member(json, "mark", marks_of);
  return finished;
}

Json to_json(const PendingEpoch& one) {
  return {one.recording, one.node, one.epoch};
}

PendingEpoch pending_epoch_of(const Json& json) {
  return {.recording = name_in(json.at(0)),
          .node = small_number(json.at(1), 1, kLastNode),
          .epoch = whole_number(json.at(2))};
}

Json to_json(const PastRecording& one) {
  return {one.recording, one.first_incarnation, one.last_incarnation};
}

PastRecording past_of(const Json& json) {
  return {.recording = name_in(json.at(0)),
          .first_incarnation = counted(json.at(1)),
          .last_incarnation = counted(json.at(2))};
}

Json to_json(const AskedSetUp& set_up) {
  return {{"asked", to_json(set_up.asked)},
          {"operation", static_cast<int>(set_up.operation)},
          {"node", set_up.node},
          {"channel", set_up.channel},
          {"value", set_up.value},
          {"nodes", set_up.nodes},
          {"vehicle_crc32c", set_up.vehicle_crc32c},
          {"state", static_cast<int>(set_up.state)},
          {"reason", static_cast<int>(set_up.reason)},
          {"text", set_up.text}};
}

AskedSetUp set_up_of(const Json& json) {
  const auto crc = [](const Json& sum) {
    return static_cast<std::uint32_t>(whole_number(sum, 0, UINT32_MAX));
  };
  const auto values = [](const Json& two) { return two.get<std::array<double, 2>>(); };
  return {.asked = member(json, "asked", key_of),
          .operation = member(json, "operation", one_of(Operation::kStart, Operation::kDatum)),
          .node = member(json, "node", number_in(0, kLastNode)),
          .channel = member(json, "channel", number_in(-1, kAccelerations - 1)),
          .value = member(json, "value", values),
          .nodes = member(json, "nodes", each(number_in(1, kLastNode))),
          .vehicle_crc32c = member(json, "vehicle_crc32c", crc),
          .state = member(json, "state", one_of(AnswerState::kUnderWay, AnswerState::kRefused)),
          .reason = member(json, "reason", one_of(RefusalReason::kNone, RefusalReason::kBusy)),
          .text = member(json, "text", text_in)};
}

// Written before a recording's first segment has its name.
bool comes_before_segments(const std::string& file) {
  return file == kIncarnationFile || file == std::string(kIncarnationFile) + ".new" ||
         (file.starts_with("seg-") && file.ends_with(".lcm.new"));
}

}  // namespace

const AskedSetUp* SessionState::set_up_asked(const RequestKey& key) const {
  if (set_up && set_up->asked == key) return &*set_up;
  const auto before = std::ranges::find(set_up_before, key, &AskedSetUp::asked);
  return before == set_up_before.end() ? nullptr : &*before;
}

void SessionState::add(AskedSetUp asked) {
  if (set_up) set_up_before.push_back(std::move(*set_up));
  if (set_up_before.size() > kMostSetUps) set_up_before.erase(set_up_before.begin());
  set_up = std::move(asked);
}

std::int64_t first_incarnation(const ActiveRecording& recording, const std::vector<PastRecording>& past) {
  std::int64_t first = recording.began_us / 1000;
  for (const PastRecording& before : past) first = std::max(first, before.last_incarnation + 1);
  return first;
}

File claim_session_state(const std::filesystem::path& recordings, Disk& disk) {
  File folder = File::open_folder(recordings, disk);
  if (!folder.try_lock())
    throw std::runtime_error("recordings " + recordings.string() + ": another rb-recorder has this folder");
  return folder;
}

SessionState read_session_state(const std::filesystem::path& recordings, Disk& disk) {
  const auto file = recordings / kSessionStateFile;
  const auto text = read_whole_text(file, disk);
  if (!text) return {};
  try {
    const Json json = Json::parse(*text);
    SessionState state;
    if (!json.is_object()) throw std::runtime_error("no object");
    if (json.contains("under_way")) state.active = member(json, "under_way", active_of);
    if (json.contains("finished")) state.finished = member(json, "finished", finished_of);
    if (json.contains("set_up")) state.set_up = member(json, "set_up", set_up_of);
    if (json.contains("set_up_before")) state.set_up_before = member(json, "set_up_before", each(set_up_of));
    if (json.contains("rest")) state.pending = member(json, "rest", each(pending_epoch_of));
    if (json.contains("over")) state.past = member(json, "over", each(past_of));
    return state;
  } catch (const std::exception& error) {
    // The parser quotes what it could not read.
    throw std::runtime_error(file.string() + ": cannot be read (" + wire_text::plain_text(error.what()) +
                             "); remove it if no recording is to go on");
  }
}

std::string text_of(const SessionState& state) {
  Json json = Json::object();
  if (state.active) json["under_way"] = to_json(*state.active);
  if (state.finished) json["finished"] = to_json(*state.finished);
  if (state.set_up) json["set_up"] = to_json(*state.set_up);
  for (const AskedSetUp& before : state.set_up_before) json["set_up_before"].push_back(to_json(before));
  for (const PendingEpoch& one : state.pending) json["rest"].push_back(to_json(one));
  for (const PastRecording& one : state.past) json["over"].push_back(to_json(one));
  return json.dump() + "\n";
}

void write_session_state(const std::filesystem::path& recordings, const SessionState& state, Disk& disk) {
  write_atomically(recordings / kSessionStateFile, text_of(state), disk);
}

std::string fault_of_name(const std::string& name) {
  if (name.empty()) return "a recording needs a name";
  if (name.size() > kMostNameBytes) return "longer than " + std::to_string(kMostNameBytes) + " bytes";
  if (name.front() == '.' || name.front() == '-' || name.front() == ' ' || name.back() == ' ')
    return "a name begins with a letter or digit and ends with no space";
  constexpr std::string_view kForbidden = "/\\:*?\"<>|";
  for (const char c : name)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F || kForbidden.find(c) != std::string_view::npos)
      return "a name has none of / \\ : * ? \" < > |";
  for (const std::string own : {kSessionStateFile, kVehicleFile})
    if (name == own || name == own + ".new") return "this name is the recorder's own";
  return "";
}

std::string fault_of_new_name(const std::string& name) {
  std::string fault = fault_of_name(name);
  return fault.empty() ? fault_of_folder_name(name) : fault;
}

namespace {

/// One that cannot be read keeps nobody from recording into the first folder.
std::string beside_fallback(const std::filesystem::path& fallback, Disk& disk) {
  try {
    return fallback.empty() ? "" : differs_by_capitals(fallback, disk);
  } catch (const std::system_error&) {
    return "";
  }
}

}  // namespace

std::string taken_by(const std::filesystem::path& folder, const std::filesystem::path& fallback,
                     const std::vector<PastRecording>& past, Disk& disk) {
  const std::string name = folder.filename().string();
  if (std::string other = differs_by_capitals(folder, disk); !other.empty()) return other;
  if (std::string other = beside_fallback(fallback, disk); !other.empty()) return other;
  if (!path_exists(folder, disk)) return "";
  const bool is_taken = !is_folder(folder, disk) ||
                        !std::ranges::all_of(list_folder(folder, disk), comes_before_segments) ||
                        std::ranges::find(past, name, &PastRecording::recording) != past.end() ||
                        (!fallback.empty() && path_exists(fallback, disk));
  return is_taken ? name : "";
}

}  // namespace roadbalance

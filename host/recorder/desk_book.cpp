#include "host/recorder/desk_book.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/bus/wire_text.hpp"
#include "common/frontend/front_end.hpp"
#include "common/link/block.hpp"
#include "common/record/folder.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recorder/json_number.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

// Of numbers that are added to: far from where an integer ends, as all are that a recorder writes.
constexpr std::int64_t kMostCounted = kRequestLimit - 1;
constexpr std::int32_t kMostMarks = 1'000'000'000;

// What `read` makes of the member; a refusal names it.
template <typename Read>
auto member(const Json& json, const char* key, Read read) {
  try {
    return read(json.at(key));
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string(key) + ": " + error.what());
  }
}

// Of each element.
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

Json to_json(const UnderWay& recording) {
  Json json = {{"name", recording.name},
               {"began_us", recording.began_us},
               {"start", to_json(recording.start)},
               {"marks", recording.marks},
               {"durable_marks", recording.durable_marks},
               {"mark", to_json(recording.mark)}};
  if (recording.stop) json["stop"] = to_json(*recording.stop);
  return json;
}

Mark mark_of(const Json& json) {
  return {small_number(json.at(0), 0, kMostMarks), key_of(json.at(1)), text_in(json.at(2))};
}

std::deque<Mark> marks_of(const Json& json) {
  const auto marks = each(mark_of)(json);
  return {marks.begin(), marks.end()};
}

UnderWay under_way_of(const Json& json) {
  UnderWay recording{.name = member(json, "name", name_in),
                     .began_us = member(json, "began_us", counted),
                     .start = member(json, "start", key_of),
                     .marks = member(json, "marks", number_in(0, kMostMarks)),
                     .durable_marks = member(json, "durable_marks", number_in(0, kMostMarks)),
                     .mark = member(json, "mark", marks_of)};
  if (json.contains("stop")) recording.stop = member(json, "stop", key_of);
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

Json to_json(const Rest& rest) {
  return {rest.recording, rest.node, rest.epoch};
}

Rest rest_of(const Json& json) {
  return {.recording = name_in(json.at(0)),
          .node = small_number(json.at(1), 1, kLastNode),
          .epoch = whole_number(json.at(2))};
}

Json to_json(const Over& over) {
  return {over.recording, over.first_incarnation, over.last_incarnation};
}

Over over_of(const Json& json) {
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

const AskedSetUp* DeskBook::set_up_asked(const RequestKey& key) const {
  if (set_up && set_up->asked == key) return &*set_up;
  const auto before = std::ranges::find(set_up_before, key, &AskedSetUp::asked);
  return before == set_up_before.end() ? nullptr : &*before;
}

void DeskBook::add(AskedSetUp asked) {
  if (set_up) set_up_before.push_back(std::move(*set_up));
  if (set_up_before.size() > kMostSetUps) set_up_before.erase(set_up_before.begin());
  set_up = std::move(asked);
}

std::int64_t first_incarnation(const UnderWay& recording, const std::vector<Over>& over) {
  std::int64_t first = recording.began_us / 1000;
  for (const Over& before : over) first = std::max(first, before.last_incarnation + 1);
  return first;
}

File claim_desk_book(const std::filesystem::path& recordings, Disk& disk) {
  File folder = File::open_folder(recordings, disk);
  if (!folder.try_lock())
    throw std::runtime_error("recordings " + recordings.string() + ": another rb-recorder has this folder");
  return folder;
}

DeskBook read_desk_book(const std::filesystem::path& recordings, Disk& disk) {
  const auto file = recordings / kDeskBookFile;
  const auto text = read_whole_text(file, disk);
  if (!text) return {};
  try {
    const Json json = Json::parse(*text);
    DeskBook book;
    if (!json.is_object()) throw std::runtime_error("no object");
    if (json.contains("under_way")) book.under_way = member(json, "under_way", under_way_of);
    if (json.contains("finished")) book.finished = member(json, "finished", finished_of);
    if (json.contains("set_up")) book.set_up = member(json, "set_up", set_up_of);
    if (json.contains("set_up_before")) book.set_up_before = member(json, "set_up_before", each(set_up_of));
    if (json.contains("rest")) book.rest = member(json, "rest", each(rest_of));
    if (json.contains("over")) book.over = member(json, "over", each(over_of));
    return book;
  } catch (const std::exception& error) {
    // The parser quotes what it could not read.
    throw std::runtime_error(file.string() + ": cannot be read (" + wire_text::plain_text(error.what()) +
                             "); remove it if no recording is to go on");
  }
}

std::string text_of(const DeskBook& book) {
  Json json = Json::object();
  if (book.under_way) json["under_way"] = to_json(*book.under_way);
  if (book.finished) json["finished"] = to_json(*book.finished);
  if (book.set_up) json["set_up"] = to_json(*book.set_up);
  for (const AskedSetUp& before : book.set_up_before) json["set_up_before"].push_back(to_json(before));
  for (const Rest& rest : book.rest) json["rest"].push_back(to_json(rest));
  for (const Over& over : book.over) json["over"].push_back(to_json(over));
  return json.dump() + "\n";
}

void write_desk_book(const std::filesystem::path& recordings, const DeskBook& book, Disk& disk) {
  write_atomically(recordings / kDeskBookFile, text_of(book), disk);
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
  for (const std::string own : {kDeskBookFile, kVehicleFile})
    if (name == own || name == own + ".new") return "this name is the recorder's own";
  return "";
}

bool is_taken(const std::filesystem::path& folder, const std::filesystem::path& fallback,
              const std::vector<Over>& over, Disk& disk) {
  if (!path_exists(folder, disk)) return false;
  if (!is_folder(folder, disk) || !std::ranges::all_of(list_folder(folder, disk), comes_before_segments))
    return true;
  return std::ranges::find(over, folder.filename().string(), &Over::recording) != over.end() ||
         (!fallback.empty() && path_exists(fallback, disk));
}

}  // namespace roadbalance

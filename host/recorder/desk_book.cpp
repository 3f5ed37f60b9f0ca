#include "host/recorder/desk_book.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/record/folder.hpp"
#include "host/recorder/incarnation.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

Json to_json(const RequestKey& key) {
  return {key.asker, key.request};
}

RequestKey key_of(const Json& json) {
  return {json.at(0).get<std::int64_t>(), json.at(1).get<std::int64_t>()};
}

Json to_json(const UnderWay& recording) {
  Json marks = Json::array();
  for (const Mark& mark : recording.mark) marks.push_back({mark.number, to_json(mark.asked), mark.text});
  Json json = {{"name", recording.name},
               {"began_us", recording.began_us},
               {"start", to_json(recording.start)},
               {"marks", recording.marks},
               {"durable_marks", recording.durable_marks},
               {"mark", marks}};
  if (recording.stop) json["stop"] = to_json(*recording.stop);
  return json;
}

UnderWay under_way_of(const Json& json) {
  UnderWay recording{.name = json.at("name").get<std::string>(),
                     .began_us = json.at("began_us").get<std::int64_t>(),
                     .start = key_of(json.at("start")),
                     .marks = json.at("marks").get<std::int32_t>(),
                     .durable_marks = json.at("durable_marks").get<std::int32_t>()};
  for (const Json& mark : json.at("mark"))
    recording.mark.push_back(
        {mark.at(0).get<std::int32_t>(), key_of(mark.at(1)), mark.at(2).get<std::string>()});
  if (json.contains("stop")) recording.stop = key_of(json.at("stop"));
  if (!fault_of_name(recording.name).empty()) throw std::runtime_error("no name of a recording");
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
  return {{"start", to_json(finished.start)}, {"stop", to_json(finished.stop)}, {"receipt", receipts}};
}

// A receipt of another release is passed over: it only repeats what the record proves.
Finished finished_of(const Json& json) {
  Finished finished{.start = key_of(json.at("start")), .stop = key_of(json.at("stop"))};
  for (const Json& receipt : json.at("receipt")) {
    const auto text = receipt.get<std::string>();
    std::vector<std::uint8_t> bytes;
    for (std::size_t k = 0; k + 1 < text.size(); k += 2)
      bytes.push_back(static_cast<std::uint8_t>(std::stoi(text.substr(k, 2), nullptr, 16)));
    if (auto known = decode_receipt(bytes)) finished.receipt.push_back(std::move(*known));
  }
  return finished;
}

Json to_json(const Rest& rest) {
  return {rest.recording, rest.node, rest.epoch};
}

Rest rest_of(const Json& json) {
  Rest rest{.recording = json.at(0).get<std::string>(),
            .node = json.at(1).get<std::int32_t>(),
            .epoch = json.at(2).get<std::int64_t>()};
  if (!fault_of_name(rest.recording).empty()) throw std::runtime_error("no name of a recording");
  return rest;
}

Json to_json(const Over& over) {
  return {over.recording, over.first_incarnation, over.last_incarnation};
}

Over over_of(const Json& json) {
  Over over{.recording = json.at(0).get<std::string>(),
            .first_incarnation = json.at(1).get<std::int64_t>(),
            .last_incarnation = json.at(2).get<std::int64_t>()};
  if (!fault_of_name(over.recording).empty()) throw std::runtime_error("no name of a recording");
  return over;
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
  return {.asked = key_of(json.at("asked")),
          .operation = static_cast<Operation>(json.at("operation").get<int>()),
          .node = json.at("node").get<std::int32_t>(),
          .channel = json.at("channel").get<std::int32_t>(),
          .value = json.at("value").get<std::array<double, 2>>(),
          .nodes = json.at("nodes").get<std::vector<std::int32_t>>(),
          .vehicle_crc32c = json.at("vehicle_crc32c").get<std::uint32_t>(),
          .state = static_cast<AnswerState>(json.at("state").get<int>()),
          .reason = static_cast<RefusalReason>(json.at("reason").get<int>()),
          .text = json.at("text").get<std::string>()};
}

// Written before a recording's first segment has its name.
bool comes_before_segments(const std::string& file) {
  return file == kIncarnationFile || file == std::string(kIncarnationFile) + ".new" ||
         (file.starts_with("seg-") && file.ends_with(".lcm.new"));
}

}  // namespace

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
  const auto text = read_text(file, disk);
  if (!text) return {};
  try {
    const Json json = Json::parse(*text);
    DeskBook book;
    if (json.contains("under_way")) book.under_way = under_way_of(json.at("under_way"));
    if (json.contains("finished")) book.finished = finished_of(json.at("finished"));
    if (json.contains("set_up")) book.set_up = set_up_of(json.at("set_up"));
    for (const Json& rest : json.value("rest", Json::array())) book.rest.push_back(rest_of(rest));
    for (const Json& over : json.value("over", Json::array())) book.over.push_back(over_of(over));
    return book;
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": cannot be read (" + error.what() +
                             "); remove it if no recording is to go on");
  }
}

std::string text_of(const DeskBook& book) {
  Json json = Json::object();
  if (book.under_way) json["under_way"] = to_json(*book.under_way);
  if (book.finished) json["finished"] = to_json(*book.finished);
  if (book.set_up) json["set_up"] = to_json(*book.set_up);
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

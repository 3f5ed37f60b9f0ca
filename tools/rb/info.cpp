#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/recording.hpp"
#include "common/clock/utc.hpp"
#include "common/record/folder.hpp"
#include "common/record/record_folder.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "common/text/printable.hpp"
#include "common/types/angle_sigma.hpp"
#include "host/recording/preamble.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "host/recording/set_clocks.hpp"
#include "host/recording/verify/verify.hpp"
#include "host/recordings/recording_summary.hpp"
#include "host/recordings/recordings_list.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/progress_line.hpp"
#include "tools/rb/reading_progress.hpp"
#include "tools/views/alarm_lines.hpp"
#include "tools/views/signal_survey.hpp"
#include "tools/views/verification_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct InfoOptions {
  std::string folder;
  bool json = false;
  bool rebuild_index = false;
};

/// Contents that verify_record() does not look at.
struct Survey {
  struct Clock {
    std::int64_t fits = 0;
    std::int64_t exchanges = 0;  // recorded
    std::int64_t breaks = 0;     // of all recorders
    std::optional<ClockFit> last;
    std::optional<SetClocks::Stamp> begins_at, ends_at;
    std::optional<std::int64_t> begins_us, ends_us;  // UTC of blocks placed by it

    bool is_known() const { return last && last->is_known(); }
  };
  /// How well the angle of the wheel on a line is known by its blocks.
  struct Angle {
    double square = 0.0;  ///< of the standard deviation, summed over scans
    std::int64_t scans = 0;
    std::optional<double> sigma_deg() const {
      if (scans == 0) return std::nullopt;
      return std::sqrt(square / static_cast<double>(scans)) * 180.0 / std::numbers::pi;
    }
  };
  std::map<NodeEpoch, std::array<Angle, kEncoderLines>> angle;
  std::map<int, std::uint64_t> segment_bytes;
  std::map<NodeEpoch, Clock> clock;
  SignalSurvey signals;
  std::int64_t first_us = 0, last_us = 0;  // 0: no event has a time
};

void count_angles(const ScanBlock& block, std::array<Survey::Angle, kEncoderLines>& angle) {
  for (int line = 0; line < kEncoderLines; ++line) {
    const auto sigma = angle_sigma_rad(block.quality, line);
    if (!sigma || (block.quality & quality_no_reference(line)) != 0) continue;
    Survey::Angle& of_line = angle[static_cast<std::size_t>(line)];
    of_line.square += *sigma * *sigma * static_cast<double>(block.header.scans);
    of_line.scans += block.header.scans;
  }
}

// Counts the block; its UTC is known if its segment or one before has a fit of its node's clock.
void look_at(const LogEvent& event, const RecordedClocks& clocks, const SetClocks& set, Survey& found) {
  SealedBlock block;
  if (!event.channel.ends_with("_SCAN") || accept(event, block) != Refusal::kNone) return;
  const NodeEpoch key{block.header.node, block.header.epoch};
  count_angles(decode_scan(block), found.angle[key]);
  const auto host_ns = clocks.host_ns(key, block.header.time_ns);
  if (block.header.sequence <= 0 || !host_ns) return;
  Survey::Clock& clock = found.clock[key];
  clock.ends_at = set.stamp(clocks.utc_us(*host_ns).value_or(0));
  if (!clock.begins_at) clock.begins_at = clock.ends_at;
}

Survey survey(const std::filesystem::path& folder) {
  Survey found;
  for (const int number : segment_numbers(folder))
    found.segment_bytes[number] = size_of_file(segment_path(folder, number));
  RecordReader reader(folder);
  reader.finish();
  RecordedClocks clocks;
  SetClocks set;
  SetClocks::Stamp first, last;
  while (const auto event = reader.next()) {
    look_at(*event, clocks, set, found);
    if (event->channel == kNoteChannel)
      if (const auto note = decode_note(event->data)) set.take(*note);
    found.signals.add(event->channel, event->data);
    if (const auto fit = clocks.take(event->channel, event->data)) {
      auto& clock = found.clock[{fit->node, fit->epoch}];
      ++clock.fits;
      // A recorder that begins anew counts from 0.
      const std::int64_t counted = clock.last ? clock.last->breaks : 0;
      clock.breaks += fit->breaks - (fit->breaks < counted ? 0 : counted);
      clock.last = *fit;
    } else if (const auto exchange = decode_clock_exchange(event->data)) {
      ++found.clock[{exchange->node, exchange->epoch}].exchanges;
    }
    if (event->timestamp_us <= 0) continue;  // descriptions before the first block
    last = set.stamp(event->timestamp_us);
    if (first.utc_us == 0) first = last;
  }
  found.first_us = set.utc_us(first);
  found.last_us = set.utc_us(last);
  for (auto& [key, clock] : found.clock) {
    if (clock.begins_at) clock.begins_us = set.utc_us(*clock.begins_at);
    if (clock.ends_at) clock.ends_us = set.utc_us(*clock.ends_at);
  }
  return found;
}

double rate_hz(const VerifiedEpoch& epoch) {
  return epoch.period_ps > 0 ? 1e12 / static_cast<double>(epoch.period_ps) : 0.0;
}

double duration_s(const VerifiedEpoch& epoch) {
  return static_cast<double>(epoch.samples + epoch.samples_missing) * static_cast<double>(epoch.period_ps) *
         1e-12;
}

/// As the record describes it.
struct Described {
  std::optional<VehicleConfig> vehicle;
  std::string name;               // or why there is none
  RecordDescription record = {};  // format 0: it does not describe itself

  const VehicleConfig* get() const { return vehicle ? &*vehicle : nullptr; }
};

/// Standard deviations of both lines: null where no block has one.
Json angles_json(const Survey& found, const NodeEpoch& key) {
  Json sigma_deg = Json::array();
  const auto angle = found.angle.find(key);
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    const auto told = angle == found.angle.end() ? std::nullopt : angle->second[line].sigma_deg();
    sigma_deg.push_back(told ? Json(*told) : Json());
  }
  return sigma_deg;
}

Json info_json(const Survey& found, const Verification& result, const Described& described) {
  Json segments = Json::array();
  for (const auto& [number, bytes] : found.segment_bytes)
    segments.push_back({{"number", number}, {"bytes", bytes}});
  Json clocks = Json::array();
  for (const auto& [key, clock] : found.clock)
    clocks.push_back({{"node", key.first},
                      {"epoch", key.second},
                      {"fits", clock.fits},
                      {"exchanges", clock.exchanges},
                      {"drift", clock.is_known() ? Json(clock.last->drift) : Json()},
                      {"uncertainty_s", clock.is_known() ? Json(clock.last->uncertainty_s) : Json()},
                      {"breaks", clock.breaks},
                      {"begins_us", clock.begins_us ? Json(*clock.begins_us) : Json()},
                      {"ends_us", clock.ends_us ? Json(*clock.ends_us) : Json()}});
  Json rates = Json::array();
  for (const auto& epoch : result.epoch)
    rates.push_back({{"node", epoch.node},
                     {"epoch", epoch.epoch},
                     {"rate_hz", rate_hz(epoch)},
                     {"duration_s", duration_s(epoch)},
                     {"angle_sigma_deg", angles_json(found, {epoch.node, epoch.epoch})}});
  return {{"vehicle", described.name},
          {"program", described.record.program},
          {"format_version", described.record.format_version},
          {"types", described.record.types},
          {"first_us", found.first_us},
          {"last_us", found.last_us},
          {"segments", segments},
          {"rates", rates},
          {"clocks", clocks},
          {"signals", signals_json(found.signals, described.get())},
          {"alarms", recorded_alarms_json(result.alarms.all())},
          {"alarms_left_out", result.alarms.left_out()},
          {"record", verification_json(result)}};
}

void print_info(const Survey& found, const Verification& result, const Described& described) {
  std::uint64_t bytes = 0;
  for (const auto& [number, size] : found.segment_bytes) bytes += size;
  const RecordDescription& by = described.record;
  if (by.format_version > 0)
    std::printf("written by %s, format %d, %zu message types described in it\n",
                printable_text(by.program).c_str(), by.format_version, by.types.size());
  std::printf("vehicle %s\n%zu segments, %.1f MiB, written within %.1f s\n", described.name.c_str(),
              found.segment_bytes.size(), static_cast<double>(bytes) / (1 << 20),
              static_cast<double>(found.last_us - found.first_us) * 1e-6);
  for (const auto& epoch : result.epoch) {
    std::printf("node %d epoch %lld: %.1f s at %.3f Hz\n", epoch.node, static_cast<long long>(epoch.epoch),
                duration_s(epoch), rate_hz(epoch));
    for (int line = 0; const auto& sigma_deg : angles_json(found, {epoch.node, epoch.epoch})) {
      if (!sigma_deg.is_null())
        std::printf("  angle on line %d: known to %.3f degrees (rms)\n", line, sigma_deg.get<double>());
      ++line;
    }
    const auto clock = found.clock.find({epoch.node, epoch.epoch});
    if (clock != found.clock.end() && clock->second.last && !clock->second.is_known())
      std::printf("  clock: not known: %lld answers, %lld questions without\n",
                  static_cast<long long>(clock->second.last->exchanges),
                  static_cast<long long>(clock->second.last->unanswered));
    else if (clock != found.clock.end() && clock->second.last)
      std::printf("  clock: %lld fits, drift %.2f ppm, last uncertainty %.1f us, %lld breaks\n",
                  static_cast<long long>(clock->second.fits), clock->second.last->drift * 1e6,
                  clock->second.last->uncertainty_s * 1e6, static_cast<long long>(clock->second.breaks));
    if (clock != found.clock.end() && clock->second.begins_us && clock->second.ends_us)
      std::printf("  from %s to %s\n", utc_text(*clock->second.begins_us).c_str(),
                  utc_text(*clock->second.ends_us).c_str());
    for (const auto& line : signal_lines(found.signals, {epoch.node, epoch.epoch}, described.get()))
      std::printf("  %s\n", line.c_str());
  }
  print_verification(result);
}

Described describe(const std::filesystem::path& folder) {
  Described described{.vehicle = std::nullopt, .name = "not described"};
  described.record = read_description(folder).value_or(RecordDescription());
  try {
    described.vehicle = recorded_vehicle(folder);
    if (described.vehicle) described.name = described.vehicle->name;
  } catch (const std::exception& error) {
    described.name = printable_text(std::string("cannot be used: ") + error.what());
  }
  return described;
}

/// The lock keeps a recorder from beginning to write meanwhile.
void rebuild(const std::filesystem::path& folder) {
  if (!is_folder(folder)) throw std::runtime_error(folder.string() + ": no such folder");
  RecordFolder lock;
  if (!lock.take(folder, kernel_disk()))
    throw std::runtime_error(folder.string() +
                             ": a recorder writes to it; its indexes can be made again when that has ended");
  const RebuiltIndexes rebuilt = rebuild_indexes(folder);
  std::fprintf(stderr, "rb: %d indexes were missing or wrong, and are made again\n", rebuilt.written);
  for (const auto& segment : rebuilt.torn)
    std::fprintf(stderr, "rb: %s gets no index: its tail is torn, as a kill or a power cut leaves it\n",
                 segment.c_str());
  for (const auto& segment : rebuilt.unknown)
    std::fprintf(stderr, "rb: %s gets no index: where the record stood before is not known here\n",
                 segment.c_str());
}

constexpr std::array kStates{"not read", "being recorded", "complete", "incomplete", "damaged", "unreadable"};

const char* state_of(const RecordingSummary& summary) {
  return kStates[static_cast<std::size_t>(summary.state)];
}

bool is_read(const RecordingSummary& summary) {
  return summary.state != RecordingState::kNotRead && summary.state != RecordingState::kGrowing;
}

double seconds_of(const RecordingSummary& summary) {
  double seconds = 0.0;
  for (const auto& node : summary.node) seconds = std::max(seconds, node.seconds);
  return seconds;
}

/// The recordings right in a folder as the page lists them: newest first, with what each proves, unless one
/// of them is being written.  Reads all of them.
std::vector<RecordingSummary> recordings_in(const std::filesystem::path& folder) {
  RecordingsList list(folder);
  list.look(RecordingsList::FileTime::clock::now());
  std::int64_t all = 0, read = 0;
  for (const ListedRecording& one : list.listed()) all += one.summary.bytes;
  ProgressLine line;
  while (const auto next = list.unread_one()) {
    const RecordingSummary summary = summary_of(*next);
    read += summary.bytes;
    list.take(summary);
    line.show(all > 0 ? static_cast<double>(read) / static_cast<double>(all) : 1.0,
              static_cast<std::uint64_t>(read));
  }
  std::vector<RecordingSummary> found;
  for (const ListedRecording& one : list.listed()) found.push_back(one.summary);
  return found;
}

Json recordings_json(const std::vector<RecordingSummary>& recordings) {
  Json all = Json::array();
  for (const RecordingSummary& summary : recordings) {
    Json one{{"name", summary.name}, {"bytes", summary.bytes}, {"state", state_of(summary)}};
    if (is_read(summary)) {
      Json nodes = Json::array();
      for (const auto& node : summary.node)
        nodes.push_back({{"node", node.node},
                         {"samples", node.samples},
                         {"samples_lost", node.samples_lost},
                         {"absent", node.absent}});
      one.update({{"vehicle", summary.vehicle},
                  {"begins", summary.first_us > 0 ? Json(utc_text(summary.first_us)) : Json()},
                  {"seconds", seconds_of(summary)},
                  {"rate_hz", summary.rate_hz},
                  {"marks", summary.marks},
                  {"nodes", nodes},
                  {"verdict", summary.verdict}});
    }
    all.push_back(one);
  }
  return {{"recordings", all}};
}

void print_recordings(const std::vector<RecordingSummary>& recordings) {
  for (const RecordingSummary& summary : recordings) {
    std::printf("%-32s %9.1f MB  %-14s", printable_text(summary.name).c_str(),
                1e-6 * static_cast<double>(summary.bytes), state_of(summary));
    if (is_read(summary))
      std::printf("  %s  %8.1f s  %zu nodes, %d marks  %s",
                  summary.first_us > 0 ? utc_text(summary.first_us).c_str() : "at a time not known",
                  seconds_of(summary), summary.node.size(), summary.marks,
                  printable_text(summary.vehicle).c_str());
    std::printf("\n");
  }
}

/// False: it is none.
bool list_folder_of_recordings(const InfoOptions& options) {
  if (!is_folder(options.folder) || !segment_numbers(options.folder).empty()) return false;
  const std::vector<RecordingSummary> found = recordings_in(options.folder);
  if (found.empty()) return false;
  if (options.json)
    std::printf("%s\n", recordings_json(found).dump().c_str());
  else
    print_recordings(found);
  return true;
}

int info(const InfoOptions& options) {
  if (options.rebuild_index) rebuild(options.folder);
  if (list_folder_of_recordings(options)) return kDone;
  std::optional<ReadingProgress> progress(std::in_place, options.folder, 2);
  const Verification result = verify_record(options.folder);
  if (result.verdict == Verdict::kUnreadable) throw std::runtime_error(result.error);
  const Survey found = survey(options.folder);
  progress.reset();
  const Described described = describe(options.folder);
  if (options.json)
    std::printf("%s\n", info_json(found, result, described).dump().c_str());
  else
    print_info(found, result, described);
  return kDone;
}

}  // namespace

void add_info(CLI::App& app, int& code) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* command = app.add_subcommand("info", "Says what is in a recording, or lists recordings");
  command->add_option("folder", options->folder, "the recording, or a folder of recordings: the newest 64")
      ->required();
  command->add_flag(
      "--rebuild-index", options->rebuild_index,
      "first make the indexes again that are missing or wrong; refused while a recorder writes to it");
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = info(*options); });
}

}  // namespace roadbalance

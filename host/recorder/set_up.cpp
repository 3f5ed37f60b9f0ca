#include "host/recorder/set_up.hpp"

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <system_error>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/link/blocks.hpp"
#include "common/link/text_crc.hpp"
#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "host/recorder/desk_answers.hpp"
#include "host/recorder/desk_book.hpp"
#include "host/recorder/vehicle_edit.hpp"

namespace roadbalance {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// Raised inside take() only: the answer has the reason already.
struct Refused {};
/// Raised inside take() only: there is nothing to change yet, and the answer says what is next.
struct Noted {};

[[noreturn]] void refuse(Answer& answer, RefusalReason reason, std::string why) {
  answer.reason = reason;
  answer.text = std::move(why);
  throw Refused{};
}

std::string read_file(const std::filesystem::path& file, Disk& disk) {
  const auto text = read_whole_text(file, disk);
  if (!text)
    throw std::system_error(std::make_error_code(std::errc::no_such_file_or_directory), file.string());
  return *text;
}

bool is_plain_name(const std::string& name) {
  return name.size() > 5 && name.ends_with(".toml") && name.front() != '.' &&
         name.find_first_of("/\\") == std::string::npos;
}

std::string vehicles_beside(const std::filesystem::path& file, Disk& disk) {
  std::vector<std::string> names;
  for (const std::string& name : list_folder(folder_of(file), disk))
    if (is_plain_name(name)) names.push_back(name);
  std::ranges::sort(names);
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

std::string what_is_done(const Request& request, const std::filesystem::path& file) {
  char text[160];
  switch (request.operation) {
    case Operation::kRange:
      std::snprintf(text, sizeof text, "channel %d.%d has a range of %g m/s²", request.node,
                    request.channel + 1, request.value[0]);
      return text;
    case Operation::kFilter:
      std::snprintf(text, sizeof text, "every node filters above %g Hz", request.value[0]);
      return text;
    case Operation::kDatum:
      std::snprintf(text, sizeof text, "%s: its zero mark fires at %.2f ± %.2f deg",
                    0 <= request.channel && request.channel < kWheels
                        ? kWheelNames[static_cast<std::size_t>(request.channel)]
                        : "a wheel",
                    request.value[0] * kDegrees, request.value[1] * kDegrees);
      return text;
    case Operation::kZero:
      return request.node == 0 ? "every channel's reading at rest is its zero"
                               : "node " + std::to_string(request.node) + ": readings at rest are the zeros";
    default:
      return file.filename().string() + " is in force";
  }
}

/// " (at node 1; node 2 was not on the bus)".
std::string whom_it_reaches(const std::string& text, const std::vector<std::int32_t>& nodes) {
  std::vector<std::int32_t> missing;
  for (const NodeConfig& node : VehicleConfig::parse(text, "").node)
    if (std::ranges::find(nodes, node.id) == nodes.end()) missing.push_back(node.id);
  std::string all = " (at node " + listed(nodes);
  if (!missing.empty()) all += "; not on the bus: node " + listed(missing);
  return all + ")";
}

}  // namespace

SetUp::SetUp(std::filesystem::path file, std::filesystem::path recordings, std::uint64_t seed, Disk& disk)
    : file_(std::move(file)), recordings_(std::move(recordings)), random_(seed), disk_(disk) {
  if (const auto chosen = read_whole_text(recordings_ / kVehicleFile, disk_)) {
    const std::string name = chosen->substr(0, chosen->find('\n'));
    if (is_plain_name(name) && path_exists(folder_of(file_) / name, disk_)) file_ = folder_of(file_) / name;
  }
  set_text(read_file(file_, disk_));
}

// @throws ConfigError if it is no vehicle
void SetUp::set_text(std::string text) {
  // A block of 20 scans is 1372 bytes on the disk with its head; edges and the rest are some per cent of
  // that.
  constexpr double kBytesOfAScan = 1.05 * 1400 / kScansPerBlock;
  double bytes_per_s = 0;
  for (const NodeConfig& node : VehicleConfig::parse(text, file_.string()).node)
    bytes_per_s += node.rate_hz * kBytesOfAScan;
  bytes_per_s_ = std::max(1.0, bytes_per_s);
  text_ = std::move(text);
  crc32c_ = roadbalance::crc32c(text_);
}

std::map<int, RestReadings::Reading> SetUp::rest(const Request& request,
                                                 const std::vector<std::int32_t>& nodes, WallTime now,
                                                 Answer& answer) const {
  const VehicleConfig vehicle = this->vehicle();
  std::map<int, RestReadings::Reading> readings;
  for (const NodeConfig& node : vehicle.node) {
    if (std::ranges::find(nodes, node.id) == nodes.end() || (request.node != 0 && request.node != node.id))
      continue;
    RestReadings::Reading reading = readings_.of(node, now);
    if (!reading.fault.empty()) refuse(answer, RefusalReason::kMoving, reading.fault);
    readings[node.id] = reading;
  }
  if (readings.empty()) refuse(answer, RefusalReason::kNoNode, "this node is not on the bus");
  return readings;
}

// The text once the channel has been read both ways up.
std::string SetUp::scaled(const Request& request, const std::vector<std::int32_t>& nodes, WallTime now,
                          Answer& answer) {
  const VehicleConfig vehicle = this->vehicle();
  const NodeConfig* node = vehicle.node_with_id(request.node);
  if (!node || request.channel < 0 || request.channel >= static_cast<int>(node->channel.size()) ||
      std::abs(request.value[0]) != 1.0)
    refuse(answer, RefusalReason::kBadArgument,
           "a scale is of a channel of vehicle.toml, its arrow up or down");
  const double mean_counts =
      rest(request, nodes, now, answer).at(node->id).mean_counts[static_cast<std::size_t>(request.channel)];
  const TurnOver::Said said = turn_over_.take(*node, request.channel, request.value[0] > 0, mean_counts, now);
  if (said.is_refused) refuse(answer, RefusalReason::kBadArgument, said.text);
  scale_said_ = said.text;
  if (said.found) return with_calibration(text_, *node, request.channel, *said.found);
  answer.text = said.text;
  throw Noted{};
}

// The text that the request asks for.
std::string SetUp::wanted(const Request& request, const std::vector<std::int32_t>& nodes, WallTime now,
                          Answer& answer, std::filesystem::path& file) {
  if (nodes.empty()) refuse(answer, RefusalReason::kNoNode, "no node is on the bus");
  switch (request.operation) {
    case Operation::kRange:
      if (std::ranges::find(nodes, request.node) == nodes.end())
        refuse(answer, RefusalReason::kNoNode, "node " + std::to_string(request.node) + " is not on the bus");
      return with_range(text_, request);
    case Operation::kFilter:
      return with_filter(text_, request);
    case Operation::kZero:
      return with_zero(text_, rest(request, nodes, now, answer));
    case Operation::kDatum:
      return with_datum(text_, request);
    case Operation::kScale:
      return scaled(request, nodes, now, answer);
    default:
      break;
  }
  file = folder_of(file_) / request.text;
  if (!is_plain_name(request.text) || !path_exists(file, disk_))
    refuse(answer, RefusalReason::kBadArgument,
           "there is no vehicle file of this name; there are: " + vehicles_beside(file_, disk_));
  return read_file(file, disk_);
}

Answer SetUp::take(const Request& request, const std::vector<std::int32_t>& nodes, std::int64_t utc_us,
                   WallTime now) {
  Answer answer = answer_to(request, utc_us);
  answer.state = AnswerState::kRefused;
  try {
    if (change_) refuse(answer, RefusalReason::kNotSupported, "another change is being made: ask again");
    set_text(read_file(file_, disk_));  // somebody may have edited it
    std::filesystem::path file = file_;
    const std::string text = wanted(request, nodes, now, answer, file);
    (void)VehicleConfig::parse(text, file.filename().string());
    if (text.size() > kMostVehicleParts * kMostVehiclePart)
      refuse(answer, RefusalReason::kBadArgument, file.filename().string() + " is too long");
    change_.emplace(Change{
        .request = request,
        .file = file,
        .done = (request.operation == Operation::kScale ? scale_said_ : what_is_done(request, file)) +
                whom_it_reaches(text, nodes),
        .push = VehiclePush(text_, text, nodes, std::max<std::int64_t>(1, utc_us / 1000), random_(), now),
        .nodes = nodes});
    answer.state = AnswerState::kUnderWay;
    answer.text = "waits for the nodes";
  } catch (const Refused&) {
  } catch (const Noted&) {
    answer.state = AnswerState::kDone;
  } catch (const ConfigError& error) {
    answer.reason = RefusalReason::kBadArgument;
    answer.text = error.what();
  } catch (const std::system_error& error) {
    answer.reason = RefusalReason::kDisk;
    answer.text = error.what();
  }
  return answer;
}

void SetUp::resume(const AskedSetUp& asked, std::int64_t utc_us, WallTime now) {
  const Request request{.asker = asked.asked.asker,
                        .request = asked.asked.request,
                        .operation = asked.operation,
                        .node = asked.node,
                        .channel = asked.channel,
                        .value = asked.value};
  change_.emplace(Change{.request = request,
                         .file = file_,
                         .done = what_is_done(request, file_) + whom_it_reaches(text_, asked.nodes),
                         .push = VehiclePush(text_, text_, asked.nodes,
                                             std::max<std::int64_t>(1, utc_us / 1000), random_(), now),
                         .nodes = asked.nodes,
                         .resumes = asked.vehicle_crc32c});
}

void SetUp::take(const Reply& reply) {
  if (change_) change_->push.take(reply);
}

void SetUp::lead(const Change& change) {
  file_ = change.file;
  set_text(change.push.text());
  turn_over_.forget();
}

std::optional<Answer> SetUp::turn(const Publish& publish, std::int64_t utc_us, WallTime now) {
  if (!change_) return std::nullopt;
  const VehiclePush::Said said = change_->push.due(now);
  for (const VehiclePart& part : said.part) (void)publish(vehicle_channel(part.node), encode(part));
  for (const Command& command : said.command) (void)publish(command_channel(command.node), encode(command));
  const auto state = change_->push.state();
  if (state == VehiclePush::State::kUnderWay || !is_settled(now)) return std::nullopt;
  Answer answer = answer_to(change_->request, utc_us);
  answer.state = AnswerState::kRefused;
  answer.text = change_->push.why();
  conclude(state, answer);
  change_.reset();
  return answer;
}

}  // namespace roadbalance

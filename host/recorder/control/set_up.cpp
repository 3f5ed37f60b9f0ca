#include "host/recorder/control/set_up.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/config/section.hpp"
#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "common/types/text_crc.hpp"
#include "host/recorder/control/session_answers.hpp"
#include "host/recorder/control/session_state.hpp"

namespace roadbalance {
namespace {

// " (at node 1; node 2 was not on the bus)".
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
    : file_(std::move(file)),
      recordings_(std::move(recordings)),
      random_(seed),
      disk_(disk),
      requested_(disk) {
  if (const auto chosen = read_whole_text(recordings_ / kVehicleFile, disk_)) {
    const std::string name = chosen->substr(0, chosen->find('\n'));
    if (is_vehicle_file_name(name) && path_exists(folder_of(file_) / name, disk_))
      file_ = folder_of(file_) / name;
  }
  set_text(read_vehicle_file(file_, disk_));
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

Answer SetUp::take(const Request& request, const std::vector<std::int32_t>& nodes, std::int64_t utc_us,
                   WallTime now) {
  Answer answer = answer_to(request, utc_us);
  answer.state = AnswerState::kRefused;
  try {
    if (change_) throw SetUpRefusal{RefusalReason::kNotSupported, "another change is being made: ask again"};
    set_text(read_vehicle_file(file_, disk_));  // a person may have edited it
    const RequestedVehicle::Wanted wanted = requested_.find(request, file_, text_, nodes, now);
    if (!wanted.text) {
      answer.state = AnswerState::kDone;
      answer.text = wanted.words;
      return answer;
    }
    const std::string& text = *wanted.text;
    const std::string name = wanted.file.filename().string();
    (void)VehicleConfig::parse(text, name);
    if (text.size() > kMostVehicleParts * kMostVehiclePart)
      throw SetUpRefusal{RefusalReason::kBadArgument, name + " is too long"};
    change_.emplace(Change{
        .request = request,
        .file = wanted.file,
        .done = wanted.words + whom_it_reaches(text, nodes),
        .push = VehiclePush(text_, text, nodes, std::max<std::int64_t>(1, utc_us / 1000), random_(), now),
        .nodes = nodes});
    answer.state = AnswerState::kUnderWay;
    answer.text = "waits for the nodes";
  } catch (const SetUpRefusal& refusal) {
    answer.reason = refusal.reason;
    answer.text = refusal.why;
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
  requested_.forget();
}

std::optional<Answer> SetUp::turn(const Publish& publish, std::int64_t utc_us, WallTime now) {
  if (!change_) return std::nullopt;
  const VehiclePush::Due due = change_->push.due(now);
  for (const VehiclePart& part : due.part) (void)publish(vehicle_channel(part.node), encode(part));
  for (const Command& command : due.command) (void)publish(command_channel(command.node), encode(command));
  const auto state = change_->push.state();
  if (state == VehiclePush::State::kUnderWay || !is_settled(now)) return std::nullopt;
  Answer answer = answer_to(change_->request, utc_us);
  answer.state = AnswerState::kRefused;
  answer.text = change_->push.why();
  conclude(state, answer);
  change_.reset();
  return answer;
}

AskedSetUp SetUp::asked() const {
  const Request& request = change_->request;
  return {.asked = {request.asker, request.request},
          .operation = request.operation,
          .node = request.node,
          .channel = request.channel,
          .value = request.value,
          .nodes = change_->nodes,
          .vehicle_crc32c = roadbalance::crc32c(change_->push.text())};
}

SetUp::Kept SetUp::kept(const Change& change) const {
  if (change.request.operation != Operation::kVehicle) return {change.file, text_, change.push.text()};
  return {recordings_ / kVehicleFile, file_.filename().string() + "\n",
          change.file.filename().string() + "\n"};
}

// If only the sync of the folder failed, after the rename, the new text is read, also by a recorder after
// this one.
bool SetUp::reads_new(const Change& change) const {
  const Kept file = kept(change);
  return read_whole_text(file.path, disk_) == file.after;
}

// A change that the nodes have taken is done when it is on the disk.  One that the disk refuses for long is
// undone at the nodes: a recorder that comes back would lead the old file, and they would measure by another.
bool SetUp::is_settled(WallTime now) {
  Change& change = *change_;
  // The file of a change that is resumed was written before, or is not written at all.
  if (change.push.state() != VehiclePush::State::kDone || change.resumes) return true;
  if (change.taken_at && now - change.tried_at < kDiskAgain) return false;
  if (!change.taken_at) change.taken_at = now;
  change.tried_at = now;
  try {
    const Kept file = kept(change);
    write_atomically(file.path, file.after, disk_);
    lead(change);
    return true;
  } catch (const std::system_error& error) {
    change.disk_error = error.what();
  }
  if (now - *change.taken_at < kDiskPatience) return false;
  try {
    if (reads_new(change)) {
      lead(change);
      change.done += "; but the disk does not confirm it (" + change.disk_error +
                     "): after a power cut the set-up may be the one of before";
      return true;
    }
  } catch (const std::system_error&) {  // then put_back() looks again
  }
  change.push.undo("the file could not be written: " + change.disk_error);
  return false;
}

// Nodes measure by the old text again.  The new one may have come to the disk with a call that failed.
// @return words about it
std::string SetUp::put_back(const Change& change) {
  try {
    if (reads_new(change)) write_atomically(kept(change).path, kept(change).before, disk_);
    return "";
  } catch (const std::system_error& error) {
    return "; its file may be the new one (" + std::string(error.what()) + ")";
  }
}

void SetUp::conclude(VehiclePush::State state, Answer& answer) {
  const bool undone = change_->resumes && *change_->resumes != crc32c_;
  if (undone) {
    answer.reason = RefusalReason::kNotSupported;
    answer.text = "the recorder was started again meanwhile: the set-up is as before, ask again" +
                  (answer.text.empty() ? "" : "; " + answer.text);
    return;
  }
  if (state == VehiclePush::State::kRefused) answer.reason = RefusalReason::kNotSupported;
  if (!change_->disk_error.empty() && state != VehiclePush::State::kDone) {
    answer.reason = RefusalReason::kDisk;
    answer.text += put_back(*change_);
  }
  if (state == VehiclePush::State::kSilent) answer.reason = RefusalReason::kNoAnswer;
  if (state != VehiclePush::State::kDone) return;
  answer.state = AnswerState::kDone;
  answer.text = change_->done;
}

}  // namespace roadbalance

#include <system_error>

#include "common/link/text_crc.hpp"
#include "common/record/file.hpp"
#include "host/recorder/set_up.hpp"

namespace roadbalance {

// How a change is remembered while it is under way, how it comes to the disk, and what is said of it in the
// end.

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

// Of a file that was renamed while only the sync of its folder failed the new text is what is read, and a
// recorder after this one goes by that.
bool SetUp::reads_new(const Change& change) const {
  const Kept file = kept(change);
  return read_whole_text(file.path, disk_) == file.after;
}

// What the nodes have taken is said to be done when it is on the disk.  What the disk refuses for long is
// undone at the nodes: a recorder that comes back would lead the old file, and they would measure by another.
bool SetUp::is_settled(WallTime now) {
  Change& change = *change_;
  // Of a change that is resumed the file was written before, or nobody writes it.
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
// @return what to say of it
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

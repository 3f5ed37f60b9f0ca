#include <system_error>

#include "common/link/text_crc.hpp"
#include "host/recorder/set_up.hpp"

namespace roadbalance {

// How a change is remembered while it is under way, and what is said of it in the end.

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

void SetUp::conclude(VehiclePush::State state, Answer& answer) {
  const bool undone = change_->resumes && *change_->resumes != crc32c_;
  if (undone) {
    answer.reason = RefusalReason::kNotSupported;
    answer.text = "the recorder was started again meanwhile: the set-up is as before, ask again" +
                  (answer.text.empty() ? "" : "; " + answer.text);
    return;
  }
  if (state == VehiclePush::State::kRefused) answer.reason = RefusalReason::kNotSupported;
  if (state == VehiclePush::State::kSilent) answer.reason = RefusalReason::kNoAnswer;
  if (state != VehiclePush::State::kDone) return;
  answer.state = AnswerState::kDone;
  answer.text = change_->done;
  if (change_->resumes) return;  // the file was written before
  try {
    put_in_force(*change_);
  } catch (const std::system_error& error) {
    // The nodes measure by it, and each recording says so; only the next start of a node does not.
    answer.text += "; but the file could not be written: " + std::string(error.what());
  }
}

}  // namespace roadbalance

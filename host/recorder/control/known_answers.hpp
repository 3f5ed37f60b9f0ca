#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/operation.hpp"
#include "host/recorder/control/session_state.hpp"

namespace roadbalance {

/// The latest answers: to be sent, to be sent again when a request is repeated, and to be followed by the
/// last word on requests that are under way.
class KnownAnswers {
 public:
  /// Sends it; the request is answered so from now on.
  void send(Answer answer);
  /// Sends it once: the request is to be repeated, and obeyed then.
  void send_once(Answer answer) { to_send_.push_back(std::move(answer)); }
  /// Sends again the answer to this request.  @return false: there is none
  bool send_again(const RequestKey& key);

  /// Marks through this number are on the disk.
  void marks_are_durable(std::int32_t through, std::int64_t utc_us);
  /// The recording has ended: the last word on marks that are under way.
  /// @param durable_marks  of it
  void end_marks(std::int32_t durable_marks);
  /// The recording was given up: a stop and marks that are under way come to nothing.
  void refuse_pending(const std::string& why, std::int64_t utc_us);

  /// To be sent, since the last call.
  std::vector<Answer> take() { return std::exchange(to_send_, {}); }

 private:
  std::deque<Answer> known_;
  std::vector<Answer> to_send_;
};

}  // namespace roadbalance

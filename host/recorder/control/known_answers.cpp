#include "host/recorder/control/known_answers.hpp"

#include <algorithm>

#include "host/recorder/control/session_answers.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kMostKnown = 64;

auto answers(const RequestKey& key) {
  return [key](const Answer& answer) { return answer.asker == key.asker && answer.request == key.request; };
}

}  // namespace

void KnownAnswers::send(Answer answer) {
  const auto known = std::ranges::find_if(known_, answers({answer.asker, answer.request}));
  if (known != known_.end())
    *known = answer;
  else
    known_.push_back(answer);
  if (known_.size() > kMostKnown) known_.pop_front();
  to_send_.push_back(std::move(answer));
}

bool KnownAnswers::send_again(const RequestKey& key) {
  const auto known = std::ranges::find_if(known_, answers(key));
  if (known == known_.end()) return false;
  to_send_.push_back(*known);
  return true;
}

void KnownAnswers::marks_are_durable(std::int32_t through, std::int64_t utc_us) {
  for (Answer& known : known_) {
    if (known.operation != Operation::kMark || known.state != AnswerState::kUnderWay) continue;
    if (known.value[0] < 1 || known.value[0] > through) continue;
    known.state = AnswerState::kDone;
    known.time_us = utc_us;
    known.text = "mark " + std::to_string(static_cast<int>(known.value[0])) + " is on the disk";
    to_send_.push_back(known);
  }
}

void KnownAnswers::end_marks(std::int32_t durable_marks) {
  for (Answer& known : known_) {
    if (known.operation != Operation::kMark || known.state != AnswerState::kUnderWay) continue;
    known = at_the_end(known, known.value[0] <= durable_marks);
    to_send_.push_back(known);
  }
}

void KnownAnswers::refuse_pending(const std::string& why, std::int64_t utc_us) {
  for (Answer& known : known_) {
    if (known.state != AnswerState::kUnderWay) continue;
    if (known.operation != Operation::kStop && known.operation != Operation::kMark) continue;
    known.state = AnswerState::kRefused;
    known.reason = RefusalReason::kDisk;
    known.time_us = utc_us;
    known.text = why;
    to_send_.push_back(known);
  }
}

}  // namespace roadbalance

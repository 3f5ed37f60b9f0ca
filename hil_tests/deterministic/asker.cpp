#include "hil_tests/deterministic/asker.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kRepeat_ns = kSecond_ns / 5;
// Nodes that do not take a set-up have twenty seconds, as long again to give it back, and may be cut off or
// busy with the rest of a recording before.
constexpr std::int64_t kPatience_ns = 120 * kSecond_ns;

// A write that the disk refused may be on it all the same, and a set-up that was done may not.
bool is_of_the_disk(const Answer& answer) {
  return answer.reason == RefusalReason::kDisk || answer.operation == Operation::kRange ||
         answer.operation == Operation::kFilter || answer.operation == Operation::kZero;
}

}  // namespace

Request Asker::invent() {
  const auto asked = static_cast<std::int64_t>(asked_.size()) + 1;
  Request request{.asker = number_, .request = asked};
  const std::string name = std::to_string(number_) + "-" + std::to_string(asked);
  const double which = random_.uniform();
  if (which < 0.3) {
    request.operation = Operation::kStart;
    request.text = "drive " + name;
  } else if (which < 0.55) {
    request.operation = Operation::kStop;
  } else if (which < 0.8) {
    request.operation = Operation::kMark;
    request.text = "mark " + name;
  } else if (which < 0.9) {
    request.operation = Operation::kRange;
    request.node = static_cast<std::int32_t>(1 + random_.below(2));
    request.channel = static_cast<std::int32_t>(random_.below(4));
    request.value = {static_cast<double>(20 + random_.below(200)), 0};
  } else if (which < 0.97) {
    request.operation = Operation::kFilter;
    request.value = {static_cast<double>(100 + random_.below(200)), 4};
  } else {
    request.operation = Operation::kZero;
  }
  return request;
}

std::optional<Request> Asker::turn(std::int64_t now_ns, bool drive_is_over, bool wants_stop,
                                   int unsure_deaths) {
  if (!waits()) {
    if (drive_is_over && !wants_stop) return std::nullopt;
    if (now_ns < next_ns_) return std::nullopt;
    Request request = invent();
    if (drive_is_over)
      request = {.asker = number_, .request = request.request, .operation = Operation::kStop};
    asked_.push_back({.request = request, .at_ns = now_ns, .unsure_deaths = unsure_deaths});
    gave_up_ = false;
    again_ns_ = now_ns;
  }
  Asked& asked = asked_.back();
  if (now_ns - asked.at_ns > kPatience_ns) {
    gave_up_ = true;
    truth_.fault("asker " + std::to_string(number_) + ": nobody answers request " +
                 std::to_string(asked.request.request) + " (operation " +
                 std::to_string(static_cast<int>(asked.request.operation)) + "), last said: \"" +
                 asked.under_way + "\"");
    return std::nullopt;
  }
  if (now_ns < again_ns_) return std::nullopt;
  again_ns_ = now_ns + kRepeat_ns;
  next_ns_ = now_ns + static_cast<std::int64_t>(random_.between(0, 3e9));
  return asked.request;
}

// The final answer is one: a restarted recorder may not give another, unless its disk had not taken
// it.
void Asker::take(const Answer& answer, int unsure_deaths) {
  if (answer.asker != number_) return;
  const std::string name =
      "asker " + std::to_string(number_) + ", request " + std::to_string(answer.request) + ": ";
  if (answer.request < 1 || answer.request > static_cast<std::int64_t>(asked_.size()))
    return truth_.fault(name + "is answered and was never asked");
  Asked& asked = asked_[static_cast<std::size_t>(answer.request - 1)];
  if (answer.operation != asked.request.operation) truth_.fault(name + "is answered as another operation");
  if (answer.state == AnswerState::kUnderWay) {
    asked.under_way = answer.text;
    return;
  }
  const bool is_unsure = unsure_deaths > asked.unsure_deaths;
  if (!asked.answer) {
    asked.answer = answer;
    asked.is_unsure = is_unsure;
  } else if (asked.answer->state != answer.state && !(is_of_the_disk(*asked.answer) && is_unsure))
    truth_.fault(name + "had the last word \"" + asked.answer->text + "\" and then \"" + answer.text + "\"");
}

}  // namespace roadbalance::test

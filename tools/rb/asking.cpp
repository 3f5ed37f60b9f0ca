#include "tools/rb/asking.hpp"

#include <algorithm>
#include <climits>

#include <pwd.h>
#include <unistd.h>

#include "common/bus/request_number.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kBusWait{20};
constexpr milliseconds kRepeat{200};
constexpr milliseconds kSilent{3000};

}  // namespace

std::string who_asks() {
  const passwd* const user = getpwuid(getuid());
  char host[HOST_NAME_MAX + 1] = "";
  (void)gethostname(host, sizeof host - 1);
  return std::string("rb of ") + (user ? user->pw_name : std::to_string(getuid())) + " at " + host;
}

Asking::Asking(const std::string& url) : bus_(url) {
  request_.asker = random_number();
  bus_.subscribe(kAnswerChannel, [this](std::string_view, auto bytes) {
    const auto answer = decode_answer(bytes);
    if (!answer || answer->asker != request_.asker || answer->request != request_.request) return;
    // One that was under way may arrive behind the last word.
    if (!answer_ || answer_->state == AnswerState::kUnderWay) answer_ = *answer;
  });
  bus_.subscribe(kReceiptChannel, [this](std::string_view, auto bytes) {
    const auto receipt = decode_receipt(bytes);
    if (!receipt) return;
    if (!receipts_.empty() && receipts_.begin()->second.ended_us != receipt->ended_us) {
      if (receipts_.begin()->second.ended_us > receipt->ended_us) return;
      receipts_.clear();
    }
    receipts_[receipt->index] = *receipt;
  });
  bus_.subscribe(kRecorderChannel, [this](std::string_view, auto bytes) {
    if (auto status = decode_recorder_status(bytes)) recorder_ = std::move(*status);
  });
}

std::optional<Answer> Asking::ask(Request request, milliseconds patience,
                                  const std::function<void()>& silent) {
  const std::int64_t asker = request_.asker;
  request_ = std::move(request);
  request_.asker = asker;
  request_.request = random_number();
  request_.who = who_asks();
  answer_.reset();
  if (request_.operation == Operation::kStop) receipts_.clear();  // those known are of another recording
  const WallTime begin = WallClock::now();
  bool is_told = !silent;
  for (WallTime asked_at{}; WallClock::now() - begin < patience;) {
    if (!is_told && !answer_ && WallClock::now() - begin > kSilent) {
      is_told = true;
      silent();
    }
    if (const WallTime now = WallClock::now(); now - asked_at >= kRepeat) {
      (void)bus_.publish(kRequestChannel, encode(request_));
      asked_at = now;
    }
    bus_.handle(kBusWait);
    if (answer_ && answer_->state != AnswerState::kUnderWay) break;
  }
  return answer_;
}

const std::map<std::int32_t, Receipt>& Asking::receipts(milliseconds patience) {
  const auto are_all_there = [this] {
    return !receipts_.empty() &&
           static_cast<std::int32_t>(receipts_.size()) >= receipts_.begin()->second.nodes;
  };
  for (const WallTime end = WallClock::now() + patience; !are_all_there() && WallClock::now() < end;)
    bus_.handle(kBusWait);
  return receipts_;
}

std::string Asking::silence() const {
  if (!recorder_) return "no recorder answers: is rb-recorder --recordings FOLDER running on this bus?";
  if (!recorder_->operable)
    return "the recorder of \"" + recorder_->name +
           "\" was started with --record: it records until it is stopped there; one with --recordings FOLDER "
           "starts and stops on request";
  return "the recorder of this bus is there and does not answer";
}

bool are_whole(const std::map<std::int32_t, Receipt>& receipts) {
  const auto is_whole = [](const auto& one) {
    const Receipt& receipt = one.second;
    return receipt.nodes > 0 && receipt.missing().empty() &&
           receipt.samples_recorded == receipt.samples_sent && receipt.gaps == 0 &&
           receipt.open_epochs == 0 && receipt.sums_agree == true;
  };
  return !receipts.empty() && static_cast<std::int32_t>(receipts.size()) >= receipts.begin()->second.nodes &&
         std::ranges::all_of(receipts, is_whole);
}

const char* text_of(RefusalReason reason) {
  switch (reason) {
    case RefusalReason::kNone:
      return "done";
    case RefusalReason::kUnknownOperation:
      return "unknown here";
    case RefusalReason::kBadArgument:
      return "cannot be";
    case RefusalReason::kRecording:
      return "not while a recording is under way";
    case RefusalReason::kNotRecording:
      return "no recording is under way";
    case RefusalReason::kNameTaken:
      return "the name is taken";
    case RefusalReason::kNoNode:
      return "no such node";
    case RefusalReason::kDisk:
      return "the disk refuses";
    case RefusalReason::kMoving:
      return "the car moves";
    case RefusalReason::kNotSupported:
      return "not to be had here";
    case RefusalReason::kNoAnswer:
      return "a node does not answer";
    case RefusalReason::kNotOperable:
      return "this recorder takes no requests";
    case RefusalReason::kBusy:
      return "one thing at a time";
  }
  return "unknown reason";
}

}  // namespace roadbalance

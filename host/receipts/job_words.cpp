#include "host/receipts/job_words.hpp"

#include <signal.h>

#include <utility>

#include "host/recorder/desk_answers.hpp"

namespace roadbalance {
namespace {

constexpr int kBySignal = 128, kCannotExecute = 127;
constexpr const char* kOfRb = "rb: ";

}  // namespace

Answer reply_to(const Request& request, AnswerState state, RefusalReason reason, std::string text,
                std::int64_t utc_us) {
  Answer answer = answer_to(request, utc_us);
  answer.state = state;
  answer.reason = reason;
  answer.text = std::move(text);
  return answer;
}

std::string in_quotes(const std::string& name) {
  return "\"" + name + "\"";
}

bool is_whole_or_nothing(JobOutcome outcome) {
  return outcome == JobOutcome::kFile || outcome == JobOutcome::kRecording;
}

bool stays(JobOutcome outcome) {
  return is_whole_or_nothing(outcome) || outcome == JobOutcome::kCopy;
}

std::string left_of(JobOutcome outcome) {
  if (outcome == JobOutcome::kCopy) return "; what is copied already stays there, and begun again it goes on";
  return is_whole_or_nothing(outcome) ? "; nothing is left of it, and begun again it begins anew" : "";
}

std::string words_of_failure(const JobLine& line, Child& ended) {
  const int code = ended.ended().value_or(0);
  const std::string command = "rb " + std::string(line.command);
  if (code == kBySignal + SIGKILL)
    return command +
           " was ended from outside, as a computer short of memory does: end other programs, or take a part" +
           left_of(line.outcome);
  if (code == kBySignal + SIGTERM || code == kBySignal + SIGINT || code == kBySignal + SIGHUP)
    return command + " was told to end, not by rb-recordings" + left_of(line.outcome);
  if (code > kBySignal)
    return command + " broke off (signal " + std::to_string(code - kBySignal) +
           "), which is a fault of the program: run it in a terminal and report what it says" +
           left_of(line.outcome);
  if (code == kCannotExecute) return command + " cannot be run: install roadbalance again";
  const std::string words = ended.last_words();
  return words.starts_with(kOfRb) ? words.substr(std::string_view(kOfRb).size()) : words;
}

}  // namespace roadbalance

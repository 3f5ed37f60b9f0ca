#include "host/recorder/control/session_answers.hpp"

#include <utility>

namespace roadbalance {

RequestKey key_of(const Request& request) {
  return {request.asker, request.request};
}

Answer done(const RequestKey& key, Operation operation, std::string text, std::int64_t utc_us) {
  return {.asker = key.asker,
          .request = key.request,
          .time_us = utc_us,
          .operation = operation,
          .state = AnswerState::kDone,
          .text = std::move(text)};
}

Answer answer_about(const Mark& mark, std::int64_t utc_us) {
  return {.asker = mark.asked.asker,
          .request = mark.asked.request,
          .time_us = utc_us,
          .operation = Operation::kMark,
          .value = {static_cast<double>(mark.number), 0},
          .text = "mark " + std::to_string(mark.number) + " is not on the disk yet"};
}

Answer at_the_end(Answer mark, bool is_durable) {
  mark.state = is_durable ? AnswerState::kDone : AnswerState::kRefused;
  mark.reason = is_durable ? RefusalReason::kNone : RefusalReason::kDisk;
  mark.text = is_durable ? "on the disk with the recording"
                         : "nobody knows whether it is on the disk: the recording has ended";
  return mark;
}

Answer answer_about(const AskedSetUp& set_up, std::int64_t utc_us) {
  return {.asker = set_up.asked.asker,
          .request = set_up.asked.request,
          .time_us = utc_us,
          .operation = set_up.operation,
          .state = set_up.state,
          .reason = set_up.reason,
          .node = set_up.node,
          .channel = set_up.channel,
          .value = set_up.value,
          .text = set_up.text.empty() ? "waits for the nodes" : set_up.text};
}

std::string listed(const std::vector<std::int32_t>& nodes) {
  std::string all;
  for (const std::int32_t node : nodes) all += (all.empty() ? "" : ", ") + std::to_string(node);
  return all;
}

std::string what_is_wrong(const std::vector<Receipt>& receipts) {
  std::vector<std::int32_t> open, contradicted;
  for (const Receipt& receipt : receipts) {
    if (receipt.nodes > 0 && receipt.open_epochs > 0) open.push_back(receipt.node);
    if (receipt.nodes > 0 && receipt.sums_agree == false) contradicted.push_back(receipt.node);
  }
  std::string wrong;
  for (const Receipt& receipt : receipts)
    if (const std::string missing = receipt.missing(); !missing.empty())
      wrong += "; node " + std::to_string(receipt.node) + " " + missing;
  if (!open.empty())
    wrong += "; node " + listed(open) +
             " has not told all of it to its end: is it on, and its cable plugged in? "
             "What it holds is fetched when it is back";
  if (!contradicted.empty())
    wrong += "; node " + listed(contradicted) +
             ": the blocks recorded are not those that its end sums up; rb verify says more";
  return wrong;
}

bool was_asked(const RequestKey& key) {
  return key.asker != 0;
}

}  // namespace roadbalance

#include <algorithm>
#include <utility>

#include "host/recorder/desk.hpp"
#include "host/recorder/desk_answers.hpp"

namespace roadbalance {

namespace {

// @return the oldest, for which there is no room any more
std::vector<Rest> add(const std::vector<Rest>& rests, DeskBook& book) {
  auto& all = book.rest;
  all.insert(all.end(), rests.begin(), rests.end());
  const auto last = all.begin() + static_cast<std::ptrdiff_t>(all.size() - std::min(all.size(), kMostRests));
  std::vector<Rest> dropped(all.begin(), last);
  all.erase(all.begin(), last);
  return dropped;
}

}  // namespace

// What the recording under way comes to: the desk's other half is what is asked of it.

void Desk::runs(bool has_samples, std::int32_t durable_marks, std::int64_t utc_us) {
  fault_.clear();
  if (!book_.under_way) return;
  if (has_samples && !std::exchange(runs_, true) && was_asked(book_.under_way->start))
    say(done(book_.under_way->start, Operation::kStart, "\"" + book_.under_way->name + "\" is being recorded",
             utc_us));
  if (durable_marks > book_.under_way->durable_marks) {
    book_.under_way->durable_marks = durable_marks;
    (void)store(book_);  // otherwise it is noted once more, under the same number
  }
  say_durable_marks(durable_marks, utc_us);
}

void Desk::marks_are_durable(std::int32_t through) {
  if (!book_.under_way) return;
  std::int32_t& durable = book_.under_way->durable_marks;
  durable = std::max(durable, through);
}

void Desk::say_durable_marks(std::int32_t durable_marks, std::int64_t utc_us) {
  for (Answer& known : known_) {
    if (known.operation != Operation::kMark || known.state != AnswerState::kUnderWay) continue;
    if (known.value[0] < 1 || known.value[0] > durable_marks) continue;
    Answer answer = known;
    answer.state = AnswerState::kDone;
    answer.time_us = utc_us;
    answer.text = "mark " + std::to_string(static_cast<int>(known.value[0])) + " is on the disk";
    known = answer;
    to_send_.push_back(std::move(answer));
  }
}

std::vector<Rest> Desk::ended(std::vector<Receipt> receipts, std::vector<Rest> rests, std::int64_t utc_us,
                              std::int64_t last_incarnation) {
  if (!book_.under_way) return {};
  const UnderWay recording = *book_.under_way;
  const RequestKey stop = recording.stop.value_or(RequestKey{});
  const std::string wrong = what_is_wrong(receipts);
  DeskBook book = book_;
  book.under_way.reset();
  book.finished = Finished{.start = recording.start,
                           .stop = stop,
                           .receipt = std::move(receipts),
                           .durable_marks = recording.durable_marks,
                           .mark = recording.mark};
  std::vector<Rest> dropped = add(rests, book);
  book.over.push_back({recording.name, first_incarnation(recording, book_.over), last_incarnation});
  if (book.over.size() > kMostOver) book.over.erase(book.over.begin());
  keep(std::move(book));
  fault_.clear();
  if (!std::exchange(runs_, true) && was_asked(recording.start))
    say(done(recording.start, Operation::kStart, "\"" + recording.name + "\" has ended", utc_us));
  if (was_asked(stop))
    say(done(stop, Operation::kStop, "\"" + recording.name + "\" is on the disk" + wrong, utc_us));
  for (Answer& known : known_) {
    if (known.operation != Operation::kMark || known.state != AnswerState::kUnderWay) continue;
    known = at_the_end(known, known.value[0] <= recording.durable_marks);
    to_send_.push_back(known);
  }
  return dropped;
}

void Desk::owe(const std::vector<Rest>& rests) {
  // One that pushed another out would make that one unknown, to be owed the next moment.
  const std::size_t room = kMostRests - std::min(kMostRests, book_.rest.size());
  const std::size_t count = std::min(room, rests.size());
  if (count == 0) return;
  DeskBook book = book_;
  (void)add({rests.begin(), rests.begin() + static_cast<std::ptrdiff_t>(count)}, book);
  keep(std::move(book));
}

void Desk::settled(const std::vector<Rest>& rests,
                   const std::function<std::vector<Receipt>(const std::vector<Receipt>&)>& complete) {
  if (rests.empty()) return;
  DeskBook book = book_;
  std::erase_if(book.rest, [&](const Rest& rest) { return std::ranges::find(rests, rest) != rests.end(); });
  if (auto& finished = book.finished;
      finished && !finished->receipt.empty() && finished->receipt.front().name == rests.front().recording)
    finished->receipt = complete(finished->receipt);
  keep(std::move(book));
}

void Desk::failed(const std::string& why, bool has_run, std::int64_t utc_us) {
  fault_ = why;
  // What comes after a session that ran may fail before it has run.
  if (has_run || runs_) is_empty_ = false;
  if (!book_.under_way || !is_empty_ || !was_asked(book_.under_way->start)) return;
  const UnderWay recording = *book_.under_way;
  DeskBook book = book_;
  book.under_way.reset();
  keep(std::move(book));
  fault_.clear();
  Answer answer = done(recording.start, Operation::kStart, why, utc_us);
  answer.state = AnswerState::kRefused;
  answer.reason = RefusalReason::kDisk;
  say(answer);
  refuse_what_waits("\"" + recording.name + "\" could not be begun: " + why, utc_us);
}

// Nothing comes any more of a stop or marks of a recording that was given up.
void Desk::refuse_what_waits(const std::string& why, std::int64_t utc_us) {
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

#include "host/recorder/desk.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "common/clock/utc.hpp"
#include "host/recorder/desk_answers.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kKnownAnswers = 64;
constexpr int kMostNoted = 100;  // of a kind, in a session: they come from whoever is on the bus

}  // namespace

std::string name_by_time(std::int64_t utc_us) {
  return utc_text(utc_us, "%Y-%m-%d %H-%M-%S");
}

Desk::Desk(Hands hands, DeskBook book) : hands_(std::move(hands)), book_(std::move(book)) {
  if (book_.under_way) again();
}

void Desk::take(const Request& request, std::int64_t utc_us, const Nodes& nodes) {
  if (answer_again(request, utc_us)) return;
  switch (request.operation) {
    case Operation::kStart:
      return start(request, utc_us, nodes);
    case Operation::kStop:
      return stop(request, utc_us);
    case Operation::kMark:
      return mark(request, utc_us);
    case Operation::kRange:
    case Operation::kFilter:
    case Operation::kZero:
    case Operation::kVehicle:
    case Operation::kScale:
    case Operation::kDatum:
      // What a count means is said once in an epoch, before its first sample.
      if (book_.under_way)
        return refuse(request, RefusalReason::kRecording,
                      "a recording has one set-up from its first sample to its last: stop it first", utc_us);
      // Else half of the car would be set up, or none of it.
      if (!nodes.returning.empty()) return wait(request, nodes.returning, utc_us);
      return set_up(request, utc_us);
    case Operation::kReading:
      return read_mark(request, utc_us);
    case Operation::kJob:
    case Operation::kCancel:
      return;  // of rb-recordings, which answers
  }
  refuse(request, RefusalReason::kUnknownOperation, "this recorder is of an older release", utc_us);
}

// What is known of it, from memory or from the book.
bool Desk::answer_again(const Request& request, std::int64_t utc_us) {
  const RequestKey key = key_of(request);
  const auto known = std::find_if(known_.begin(), known_.end(), [&](const Answer& answer) {
    return answer.asker == key.asker && answer.request == key.request;
  });
  if (known != known_.end()) {
    to_send_.push_back(*known);
    return true;
  }
  if (const auto& recording = book_.under_way) {
    if (key == recording->start || (recording->stop && key == *recording->stop)) {
      say(answer_to(request, utc_us));  // runs() or ended() says the rest
      return true;
    }
    if (const auto mark = std::ranges::find(recording->mark, key, &Mark::asked);
        mark != recording->mark.end()) {
      say(answer_about(*mark, utc_us));
      if (mark->number <= recording->durable_marks) say_durable_marks(recording->durable_marks, utc_us);
      return true;
    }
  }
  if (const AskedSetUp* const asked = book_.set_up_asked(key)) {
    say(answer_about(*asked, utc_us));  // was_set_up() says the rest of what is under way
    return true;
  }
  const auto& finished = book_.finished;
  if (!finished) return false;
  if (key == finished->start || key == finished->stop) {
    say(done(key, request.operation, "the recording has ended", utc_us));
    return true;
  }
  const auto mark = std::ranges::find(finished->mark, key, &Mark::asked);
  if (mark == finished->mark.end()) return false;
  say(at_the_end(answer_about(*mark, utc_us), mark->number <= finished->durable_marks));
  return true;
}

bool Desk::store(DeskBook book) {
  try {
    hands_.store(book);
    book_ = std::move(book);
    is_written_ = true;
    return true;
  } catch (const std::system_error& error) {
    store_fault_ = error.what();
    is_written_ = false;  // either may be on the disk
    return false;
  }
}

// What has happened cannot wait for a disk.
void Desk::keep(DeskBook book) {
  if (!store(book)) book_ = std::move(book);
}

void Desk::write_again() {
  if (!is_written_) (void)store(book_);
}

void Desk::start(const Request& request, std::int64_t utc_us, const Nodes& nodes) {
  if (book_.under_way)
    return refuse(request, RefusalReason::kRecording,
                  "\"" + book_.under_way->name + "\" is being recorded: stop it first", utc_us);
  // It would have one set-up at one node and another at the next.
  if (hands_.is_set_up_under_way())
    return refuse(request, RefusalReason::kNotSupported,
                  "the nodes are being set up: start again when that is done", utc_us);
  const std::string name = request.text.empty() ? name_by_time(utc_us) : request.text;
  if (const std::string fault = fault_of_name(name); !fault.empty())
    return refuse(request, RefusalReason::kBadArgument, "\"" + name + "\": " + fault, utc_us);
  try {
    if (hands_.exists(name))
      return refuse(request, RefusalReason::kNameTaken,
                    "there is a recording \"" + name + "\": choose another name", utc_us);
  } catch (const std::system_error& error) {
    return refuse(request, RefusalReason::kDisk, error.what(), utc_us);
  }
  if (nodes.there == 0 && !nodes.returning.empty()) return wait(request, nodes.returning, utc_us);
  if (nodes.there == 0)
    return refuse(request, RefusalReason::kNoNode,
                  "no node is on the bus: is rb-node running, and are its cables plugged in?", utc_us);
  DeskBook book = book_;
  book.under_way = UnderWay{.name = name, .began_us = utc_us, .start = key_of(request)};
  if (!store(std::move(book))) return refuse(request, RefusalReason::kDisk, store_fault_, utc_us);
  is_empty_ = true;
  again();
  note_asked(request, RefusalReason::kNone, "start \"" + name + "\"");
  Answer answer = answer_to(request, utc_us);
  answer.text = "waits for the first samples of \"" + name + "\"";
  say(answer);
}

void Desk::begin(const std::string& name, std::int64_t utc_us) {
  if (book_.under_way) return;
  DeskBook book = book_;
  book.under_way = UnderWay{.name = name, .began_us = utc_us};
  hands_.store(book);
  book_ = std::move(book);
  again();
}

void Desk::again() {
  runs_ = false;
  others_noted_ = readings_noted_ = 0;
  fault_.clear();
  hands_.begin(*book_.under_way);
  for (const Mark& mark : book_.under_way->mark)
    if (mark.number > book_.under_way->durable_marks) note(mark);
  if (is_stopping()) hands_.stop();
}

void Desk::end() {
  ends_ = true;
  if (book_.under_way) hands_.stop();
}

void Desk::stop(const Request& request, std::int64_t utc_us) {
  if (!book_.under_way)
    return refuse(request, RefusalReason::kNotRecording, "nothing is being recorded", utc_us);
  if (book_.under_way->stop)
    return refuse(request, RefusalReason::kNotRecording, "it is being stopped already", utc_us);
  note_asked(request, RefusalReason::kNone, "stop");
  DeskBook book = book_;
  book.under_way->stop = key_of(request);
  // A book that cannot be written now must not keep a recording from its end.
  keep(std::move(book));
  Answer answer = answer_to(request, utc_us);
  answer.text = "waits for the nodes' last samples";
  say(answer);
  hands_.stop();
}

void Desk::mark(const Request& request, std::int64_t utc_us) {
  if (!book_.under_way || is_stopping())
    return refuse(request, RefusalReason::kNotRecording, "a mark is set into a recording: start one", utc_us);
  // A mark that is no longer in the book would be lost with the recorder.
  if (book_.under_way->marks - book_.under_way->durable_marks >= static_cast<std::int32_t>(kMarksRemembered))
    return refuse(request, RefusalReason::kDisk,
                  std::to_string(kMarksRemembered) + " marks wait for the disk: ask again", utc_us);
  DeskBook book = book_;
  UnderWay& recording = *book.under_way;
  const Mark mark{.number = ++recording.marks, .asked = key_of(request), .text = request.text};
  recording.mark.push_back(mark);
  if (recording.mark.size() > kMarksRemembered) recording.mark.pop_front();
  keep(std::move(book));
  note(mark);
  say(answer_about(mark, utc_us));
}

void Desk::set_up(const Request& request, std::int64_t utc_us) {
  const Answer answer = hands_.set_up(request);
  if (answer.state == AnswerState::kUnderWay) {
    DeskBook book = book_;
    book.add(hands_.asked_set_up());
    if (!store(std::move(book))) {
      hands_.forget_set_up();
      return refuse(request, RefusalReason::kDisk, store_fault_, utc_us);
    }
  }
  say(answer);
}

void Desk::wait(const Request& request, const std::vector<std::int32_t>& returning, std::int64_t utc_us) {
  Answer answer = answer_to(request, utc_us);
  answer.text = "waits for node " + listed(returning) + ", which has just left, to return";
  to_send_.push_back(std::move(answer));
}

void Desk::read_mark(const Request& request, std::int64_t utc_us) {
  if (!book_.under_way || is_stopping())
    return refuse(request, RefusalReason::kNotRecording,
                  "nodes send the edges of wheels while a recording is under way: start one", utc_us);
  Answer answer = hands_.read_mark(request);
  if (answer.state == AnswerState::kRefused)
    return refuse(request, answer.reason, std::move(answer.text), utc_us);
  answer.time_us = utc_us;
  // Whoever begins with a wheel again and again must not keep readings that count from the record.
  const bool counts = request.value[1] != 0.0;
  note_some(counts ? readings_noted_ : others_noted_, request, RefusalReason::kNone, answer.text);
  say(std::move(answer));
}

void Desk::was_set_up(const Answer& answer) {
  if (book_.set_up && book_.set_up->asked == RequestKey{answer.asker, answer.request}) {
    DeskBook book = book_;
    book.set_up->state = answer.state;
    book.set_up->reason = answer.reason;
    book.set_up->text = answer.text;
    keep(std::move(book));
  }
  say(answer);
}

void Desk::note(const Mark& mark) {
  hands_.note({.kind = NoteKind::kMark, .a = mark.number, .b = mark.asked.request, .text = mark.text});
}

void Desk::refuse(const Request& request, RefusalReason reason, std::string why, std::int64_t utc_us) {
  Answer answer = answer_to(request, utc_us);
  answer.state = AnswerState::kRefused;
  answer.reason = reason;
  answer.text = std::move(why);
  note_some(others_noted_, request, reason, "refused: " + answer.text);
  say(answer);
}

void Desk::note_asked(const Request& request, RefusalReason reason, const std::string& what) {
  if (!book_.under_way) return;
  hands_.note({.kind = NoteKind::kAsked,
               .a = static_cast<std::int64_t>(request.operation),
               .b = static_cast<std::int64_t>(reason),
               .text = what});
}

void Desk::note_some(int& noted, const Request& request, RefusalReason reason, const std::string& what) {
  if (noted >= kMostNoted) return;
  const bool is_last = ++noted == kMostNoted;
  note_asked(request, reason, is_last ? what + " (more like this is not noted)" : what);
}

void Desk::say(Answer answer) {
  const auto known = std::ranges::find_if(
      known_, [&](const Answer& old) { return old.asker == answer.asker && old.request == answer.request; });
  if (known != known_.end())
    *known = answer;
  else
    known_.push_back(answer);
  if (known_.size() > kKnownAnswers) known_.pop_front();
  to_send_.push_back(std::move(answer));
}

}  // namespace roadbalance

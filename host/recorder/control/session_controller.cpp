#include "host/recorder/control/session_controller.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "common/clock/utc.hpp"
#include "common/config/section.hpp"
#include "common/text/printable.hpp"
#include "host/recorder/control/session_answers.hpp"

namespace roadbalance {
namespace {

// "; PARTIAL: node 2 (rear) is not on the bus"; empty: it is none.
std::string partial_words(const ActiveRecording& recording) {
  std::string missing;
  for (const std::string& node : recording.missing) missing += (missing.empty() ? "" : ", ") + node;
  if (missing.empty()) return "";
  return "; PARTIAL: " + missing + (recording.missing.size() == 1 ? " is" : " are") + " not on the bus";
}

constexpr int kMostNoted = 100;  // of a kind, in a session: they may come from anyone on the bus

}  // namespace

std::string name_by_time(std::int64_t utc_us) {
  return utc_text(utc_us, "%Y-%m-%d %H-%M-%S");
}

SessionController::SessionController(Callbacks callbacks, SessionState state)
    : callbacks_(std::move(callbacks)), state_(std::move(state)) {
  if (state_.active) again();
}

void SessionController::take(const Request& request, std::int64_t utc_us, const Nodes& nodes) {
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
      // The meaning of a count is declared once in an epoch, before its first sample.
      if (state_.active)
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

// From memory or from the session state.
bool SessionController::answer_again(const Request& request, std::int64_t utc_us) {
  const RequestKey key = key_of(request);
  if (answers_.send_again(key)) return true;
  if (const auto& recording = state_.active) {
    if (key == recording->start || (recording->stop && key == *recording->stop)) {
      answers_.send(answer_to(request, utc_us));  // runs() or ended() answers further
      return true;
    }
    if (const auto mark = std::ranges::find(recording->mark, key, &Mark::asked);
        mark != recording->mark.end()) {
      answers_.send(answer_about(*mark, utc_us));
      if (mark->number <= recording->durable_marks)
        answers_.marks_are_durable(recording->durable_marks, utc_us);
      return true;
    }
  }
  if (const AskedSetUp* const asked = state_.set_up_asked(key)) {
    answers_.send(answer_about(*asked, utc_us));  // was_set_up() answers further one that is under way
    return true;
  }
  const auto& finished = state_.finished;
  if (!finished) return false;
  if (key == finished->start || key == finished->stop) {
    answers_.send(done(key, request.operation, "the recording has ended", utc_us));
    return true;
  }
  const auto mark = std::ranges::find(finished->mark, key, &Mark::asked);
  if (mark == finished->mark.end()) return false;
  answers_.send(at_the_end(answer_about(*mark, utc_us), mark->number <= finished->durable_marks));
  return true;
}

bool SessionController::store(SessionState state) {
  try {
    callbacks_.store(state);
    state_ = std::move(state);
    is_written_ = true;
    return true;
  } catch (const std::system_error& error) {
    store_fault_ = error.what();
    is_written_ = false;  // either may be on the disk
    return false;
  }
}

// Something that has happened cannot wait for a disk.
void SessionController::keep(SessionState state) {
  if (!store(state)) state_ = std::move(state);
}

void SessionController::write_again() {
  if (!is_written_) (void)store(state_);
}

void SessionController::start(const Request& request, std::int64_t utc_us, const Nodes& nodes) {
  if (state_.active)
    return refuse(request, RefusalReason::kRecording,
                  "\"" + state_.active->name + "\" is being recorded: stop it first", utc_us);
  // It would have one set-up at one node and another at the next.
  if (callbacks_.is_set_up_under_way())
    return refuse(request, RefusalReason::kNotSupported,
                  "the nodes are being set up: start again when that is done", utc_us);
  const std::string name = request.text.empty() ? name_by_time(utc_us) : request.text;
  if (const std::string fault = fault_of_new_name(name); !fault.empty())
    return refuse(request, RefusalReason::kBadArgument, "\"" + name + "\": " + fault, utc_us);
  try {
    if (const std::string taken = callbacks_.taken_by(name); !taken.empty())
      return refuse(request, RefusalReason::kNameTaken,
                    "there is a recording \"" + taken + "\": choose another name", utc_us);
  } catch (const std::system_error& error) {
    return refuse(request, RefusalReason::kDisk, error.what(), utc_us);
  }
  ChosenNodes chosen;
  try {
    chosen = callbacks_.choose(request.nodes);
  } catch (const ConfigError& error) {
    return refuse(request, RefusalReason::kBadArgument, error.what(), utc_us);
  }
  const bool is_any_there = nodes.there > 0 && chosen.is_any_there;
  const bool waits = std::ranges::any_of(chosen.missing, [&](const ExpectedNode& node) {
    return std::ranges::find(nodes.returning, node.number) != nodes.returning.end();
  });
  if (waits || (!is_any_there && !nodes.returning.empty())) return wait(request, nodes.returning, utc_us);
  if (!is_any_there)
    return refuse(request, RefusalReason::kNoNode,
                  nodes.there > 0
                      ? "node " + request.nodes + " is not on the bus: is its rb-node running?"
                      : "no node is on the bus: is rb-node running, and are its cables plugged in?",
                  utc_us);
  SessionState state = state_;
  state.active = ActiveRecording{
      .name = name, .began_us = utc_us, .start = key_of(request), .nodes = std::move(chosen.nodes)};
  for (const ExpectedNode& node : chosen.missing)
    state.active->missing.push_back(node_words(node.number, node.name));
  if (!store(std::move(state))) return refuse(request, RefusalReason::kDisk, store_fault_, utc_us);
  is_empty_ = began_here_ = true;
  again();
  const std::string partial = partial_words(*state_.active);
  note_asked(request, RefusalReason::kNone,
             "start \"" + name + "\"" + (request.nodes.empty() ? "" : " of " + request.nodes) + partial);
  Answer answer = answer_to(request, utc_us);
  answer.text = "waits for the first samples of \"" + name + "\"" + partial;
  answers_.send(answer);
}

void SessionController::begin(const std::string& name, std::int64_t utc_us) {
  if (state_.active) return;
  if (const std::string taken = callbacks_.taken_by(name); !taken.empty())
    throw ConfigError("--start " + name + ": there is a recording \"" + taken + "\": choose another name");
  SessionState state = state_;
  state.active = ActiveRecording{.name = name, .began_us = utc_us};
  callbacks_.store(state);
  state_ = std::move(state);
  began_here_ = true;
  again();
}

void SessionController::again() {
  runs_ = false;
  others_noted_ = readings_noted_ = 0;
  fault_.clear();
  callbacks_.begin(*state_.active);
  for (const Mark& mark : state_.active->mark)
    if (mark.number > state_.active->durable_marks) note(mark);
  if (is_stopping()) callbacks_.stop(stopped_by());
}

void SessionController::end() {
  ends_ = true;
  if (state_.active) callbacks_.stop(stopped_by());
}

std::string SessionController::stopped_by() const {
  const bool was_asked = state_.active && state_.active->stop;
  return was_asked ? state_.active->stopped_by : kStoppedBySignal;
}

void SessionController::stop(const Request& request, std::int64_t utc_us) {
  if (!state_.active)
    return refuse(request, RefusalReason::kNotRecording, "nothing is being recorded", utc_us);
  if (state_.active->stop)
    return refuse(request, RefusalReason::kNotRecording,
                  "it is being stopped already, by " + state_.active->stopped_by, utc_us);
  note_asked(request, RefusalReason::kNone, "stop");
  SessionState state = state_;
  state.active->stop = key_of(request);
  state.active->stopped_by = request.who.empty() ? "somebody who gave no name" : request.who;
  // A session state that cannot be written now must not keep a recording from its end.
  keep(std::move(state));
  Answer answer = answer_to(request, utc_us);
  answer.text = "waits for the nodes' last samples";
  answers_.send(answer);
  callbacks_.stop(stopped_by());
}

void SessionController::mark(const Request& request, std::int64_t utc_us) {
  if (const std::string hidden = first_hidden(request.text); !hidden.empty())
    return refuse(request, RefusalReason::kBadArgument,
                  "a mark's text has the hidden character " + hidden + ": write it without", utc_us);
  if (!state_.active || is_stopping())
    return refuse(request, RefusalReason::kNotRecording, "a mark is set into a recording: start one", utc_us);
  // A mark that is no longer in the session state would be lost with the recorder.
  if (state_.active->marks - state_.active->durable_marks >= static_cast<std::int32_t>(kMarksRemembered))
    return refuse(request, RefusalReason::kDisk,
                  std::to_string(kMarksRemembered) + " marks wait for the disk: ask again", utc_us);
  SessionState state = state_;
  ActiveRecording& recording = *state.active;
  const Mark mark{.number = ++recording.marks, .asked = key_of(request), .text = request.text};
  recording.mark.push_back(mark);
  if (recording.mark.size() > kMarksRemembered) recording.mark.pop_front();
  keep(std::move(state));
  note(mark);
  answers_.send(answer_about(mark, utc_us));
}

void SessionController::set_up(const Request& request, std::int64_t utc_us) {
  const Answer answer = callbacks_.set_up(request);
  if (answer.state == AnswerState::kUnderWay) {
    SessionState state = state_;
    state.add(callbacks_.asked_set_up());
    if (!store(std::move(state))) {
      callbacks_.forget_set_up();
      return refuse(request, RefusalReason::kDisk, store_fault_, utc_us);
    }
  }
  answers_.send(answer);
}

void SessionController::wait(const Request& request, const std::vector<std::int32_t>& returning,
                             std::int64_t utc_us) {
  Answer answer = answer_to(request, utc_us);
  answer.text = "waits for node " + listed(returning) + ", which has just left, to return";
  answers_.send_once(std::move(answer));
}

void SessionController::read_mark(const Request& request, std::int64_t utc_us) {
  if (!state_.active || is_stopping())
    return refuse(request, RefusalReason::kNotRecording,
                  "nodes send the edges of wheels while a recording is under way: start one", utc_us);
  Answer answer = callbacks_.read_mark(request);
  if (answer.state == AnswerState::kRefused)
    return refuse(request, answer.reason, std::move(answer.text), utc_us);
  answer.time_us = utc_us;
  // A person who begins with a wheel again and again must not keep readings that count from the record.
  const bool counts = request.value[1] != 0.0;
  note_some(counts ? readings_noted_ : others_noted_, request, RefusalReason::kNone, answer.text);
  answers_.send(std::move(answer));
}

void SessionController::was_set_up(const Answer& answer) {
  if (state_.set_up && state_.set_up->asked == RequestKey{answer.asker, answer.request}) {
    SessionState state = state_;
    state.set_up->state = answer.state;
    state.set_up->reason = answer.reason;
    state.set_up->text = answer.text;
    keep(std::move(state));
  }
  answers_.send(answer);
}

void SessionController::note(const Mark& mark) {
  callbacks_.note({.kind = NoteKind::kMark, .a = mark.number, .b = mark.asked.request, .text = mark.text});
}

void SessionController::refuse(const Request& request, RefusalReason reason, std::string why,
                               std::int64_t utc_us) {
  Answer answer = answer_to(request, utc_us);
  answer.state = AnswerState::kRefused;
  answer.reason = reason;
  answer.text = std::move(why);
  note_some(others_noted_, request, reason, "refused: " + answer.text);
  answers_.send(answer);
}

void SessionController::note_asked(const Request& request, RefusalReason reason, const std::string& what) {
  if (!state_.active) return;
  callbacks_.note({.kind = NoteKind::kAsked,
                   .a = static_cast<std::int64_t>(request.operation),
                   .b = static_cast<std::int64_t>(reason),
                   .text = request.who.empty() ? what : what + " (" + request.who + ")"});
}

void SessionController::note_some(int& noted, const Request& request, RefusalReason reason,
                                  const std::string& what) {
  if (noted >= kMostNoted) return;
  const bool is_last = ++noted == kMostNoted;
  note_asked(request, reason, is_last ? what + " (more like this is not noted)" : what);
}

namespace {

// @return the oldest, for which there is no room any more
std::vector<PendingEpoch> add(const std::vector<PendingEpoch>& pending, SessionState& state) {
  auto& all = state.pending;
  all.insert(all.end(), pending.begin(), pending.end());
  const auto last =
      all.begin() + static_cast<std::ptrdiff_t>(all.size() - std::min(all.size(), kMostPendingEpochs));
  std::vector<PendingEpoch> dropped(all.begin(), last);
  all.erase(all.begin(), last);
  return dropped;
}

}  // namespace

void SessionController::runs(bool has_samples, std::int32_t durable_marks, std::int64_t utc_us) {
  fault_.clear();
  if (!state_.active) return;
  if (has_samples && !std::exchange(runs_, true) && was_asked(state_.active->start)) {
    const ActiveRecording& recording = *state_.active;
    Answer answer = done(recording.start, Operation::kStart,
                         "\"" + recording.name + "\" is being recorded" + partial_words(recording), utc_us);
    answer.value[0] = static_cast<double>(recording.missing.size());
    answers_.send(answer);
  }
  if (durable_marks > state_.active->durable_marks) {
    state_.active->durable_marks = durable_marks;
    (void)store(state_);  // otherwise it is noted once more, under the same number
  }
  answers_.marks_are_durable(durable_marks, utc_us);
}

void SessionController::are_absent(std::vector<Absence> absence) {
  if (!state_.active) return;
  for (Absence& one : absence)
    if (one.to_end) one.seconds = 0.0;  // it grows
  const auto is_known = [](const Absence& a, const Absence& b) {
    return a.node == b.node && a.cause == b.cause && a.to_end == b.to_end;
  };
  if (std::ranges::equal(absence, state_.active->absence, is_known)) return;
  SessionState state = state_;
  state.active->absence = std::move(absence);
  keep(std::move(state));
}

void SessionController::clock_was_set(std::int64_t change_us) {
  if (!state_.active || !began_here_) return;
  SessionState state = state_;
  state.active->clock_set_us += change_us;
  keep(std::move(state));
}

void SessionController::marks_are_durable(std::int32_t through) {
  if (!state_.active) return;
  std::int32_t& durable = state_.active->durable_marks;
  durable = std::max(durable, through);
}

std::vector<PendingEpoch> SessionController::ended(std::vector<Receipt> receipts,
                                                   std::vector<PendingEpoch> pending, std::int64_t utc_us,
                                                   std::int64_t last_incarnation) {
  if (!state_.active) return {};
  const ActiveRecording recording = *state_.active;
  const RequestKey stop = recording.stop.value_or(RequestKey{});
  const std::string wrong = what_is_wrong(receipts);
  SessionState state = state_;
  state.active.reset();
  state.finished = Finished{.start = recording.start,
                            .stop = stop,
                            .receipt = std::move(receipts),
                            .durable_marks = recording.durable_marks,
                            .mark = recording.mark};
  std::vector<PendingEpoch> dropped = add(pending, state);
  state.past.push_back({recording.name, first_incarnation(recording, state_.past), last_incarnation});
  if (state.past.size() > kMostPast) state.past.erase(state.past.begin());
  keep(std::move(state));
  fault_.clear();
  if (!std::exchange(runs_, true) && was_asked(recording.start))
    answers_.send(done(recording.start, Operation::kStart, "\"" + recording.name + "\" has ended", utc_us));
  if (was_asked(stop))
    answers_.send(done(stop, Operation::kStop, "\"" + recording.name + "\" is on the disk" + wrong, utc_us));
  answers_.end_marks(recording.durable_marks);
  return dropped;
}

void SessionController::owe(const std::vector<PendingEpoch>& pending) {
  // One that pushed another out would make that one unknown, to be owed the next moment.
  const std::size_t room = kMostPendingEpochs - std::min(kMostPendingEpochs, state_.pending.size());
  const std::size_t count = std::min(room, pending.size());
  if (count == 0) return;
  SessionState state = state_;
  (void)add({pending.begin(), pending.begin() + static_cast<std::ptrdiff_t>(count)}, state);
  keep(std::move(state));
}

void SessionController::settled(
    const std::vector<PendingEpoch>& pending,
    const std::function<std::vector<Receipt>(const std::vector<Receipt>&)>& complete) {
  if (pending.empty()) return;
  SessionState state = state_;
  std::erase_if(state.pending,
                [&](const PendingEpoch& one) { return std::ranges::find(pending, one) != pending.end(); });
  if (auto& finished = state.finished;
      finished && !finished->receipt.empty() && finished->receipt.front().name == pending.front().recording)
    finished->receipt = complete(finished->receipt);
  keep(std::move(state));
}

void SessionController::failed(const std::string& why, bool has_run, std::int64_t utc_us) {
  fault_ = why;
  // A session that follows one that ran may fail before it has run.
  if (has_run || runs_) is_empty_ = false;
  if (!state_.active || !is_empty_ || !was_asked(state_.active->start)) return;
  const ActiveRecording recording = *state_.active;
  SessionState state = state_;
  state.active.reset();
  keep(std::move(state));
  fault_.clear();
  Answer answer = done(recording.start, Operation::kStart, why, utc_us);
  answer.state = AnswerState::kRefused;
  answer.reason = RefusalReason::kDisk;
  answers_.send(answer);
  answers_.refuse_pending("\"" + recording.name + "\" could not be begun: " + why, utc_us);
}

}  // namespace roadbalance

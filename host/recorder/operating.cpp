#include "host/recorder/operating.hpp"

#include <algorithm>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control.hpp"
#include "common/record/folder.hpp"
#include "host/recorder/receipts.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kSettling{1000};

}  // namespace

Operating::Operating(const OperateOptions& options, World world, Time time)
    : options_(options),
      world_(std::move(world)),
      claim_(claim_desk_book(options.recordings, world_.disk)),
      time_(time),
      recorder_(static_cast<std::int64_t>(world_.seed % static_cast<std::uint64_t>(kRequestLimit - 1)) + 1),
      rests_(
          [this](const std::string& name, EpochScope scope) { return begin_rest(name, std::move(scope)); },
          [this](const std::string& name, std::int64_t incarnation) { return has_had(name, incarnation); }),
      desk_(hands(), with_vehicle(read_desk_book(options.recordings, world_.disk))) {
  know_book();
  if (options.start) desk_.begin(*options.start, time.utc_us);
}

// A folder without one could be any.
void Operating::know_book() {
  try {
    if (const auto text = read_whole_text(options_.recordings / kDeskBookFile, world_.disk))
      book_texts_.insert(*text);
    if (book_texts_.empty()) store({});
  } catch (const std::system_error& error) {
    warn(error.what());
  }
}

// Before the desk, which goes on with what the book has under way: a vehicle file that is broken must not
// end that.
DeskBook Operating::with_vehicle(DeskBook book) {
  const bool is_under_way = book.set_up && book.set_up->state == AnswerState::kUnderWay;
  if (options_.vehicle.empty()) {
    if (is_under_way) {
      book.set_up->state = AnswerState::kRefused;
      book.set_up->reason = RefusalReason::kNotSupported;
      book.set_up->text = no_set_up_;
    }
    return book;
  }
  try {
    set_up_.emplace(options_.vehicle, options_.recordings, world_.seed, world_.disk);
    if (is_under_way) set_up_->resume(*book.set_up, time_.utc_us, time_.now);
  } catch (const std::exception& error) {
    if (!book.under_way) throw;
    set_up_.reset();
    no_set_up_ = error.what() + std::string(": mend the file and start rb-recorder again");
    warn("goes on without its vehicle file: " + no_set_up_);
  }
  return book;
}

void Operating::take(std::string_view channel, std::span<const std::uint8_t> bytes, Time time) {
  time_ = time;
  if (channel == kRequestChannel) {
    if (const auto request = decode_request(bytes); request && !is_of_recordings(request->operation))
      desk_.take(*request, time.utc_us, {heard_.count(time.now), heard_.left(time.now)});
  } else if (channel.starts_with("RB_HEARTBEAT_")) {
    heard_.take(bytes, time.now);
    if (const auto beat = decode_heartbeat(bytes)) rests_.take(*beat, time.now);
  } else if (channel.starts_with(kClockChannels)) {
    hear_clock(bytes);
  } else if (set_up_ && channel.starts_with("RB_REPLY_")) {
    if (const auto reply = decode_reply(bytes)) set_up_->take(*reply);
  } else if (set_up_ && channel.starts_with("RB_PREVIEW_")) {
    if (accept(bytes, block_) == Refusal::kNone && block_.kind == BlockKind::kScan)
      set_up_->take(decode_scan(block_), time.now);
  } else if (mark_readings_.listens() && channel.starts_with(kBlockChannels)) {
    if (accept(bytes, block_) == Refusal::kNone) mark_readings_.take(block_, time.now);
  }
}

bool Operating::turn(bool told_to_stop, Time time, const Publish& publish) {
  time_ = time;
  if (told_to_stop && !std::exchange(ends_, true)) {
    rests_.leave();
    desk_.end();
  }
  look_after_recording();
  if (time_.now - written_again_at_ >= kAgain) {
    written_again_at_ = time_.now;
    desk_.write_again();
  }
  note_marks();
  if (!ends_) look_after_rests();
  if (set_up_)
    if (const auto answer = set_up_->turn(publish, time.utc_us, time.now)) desk_.was_set_up(*answer);
  for (const Answer& answer : desk_.answers()) (void)publish(kAnswerChannel, encode(answer));
  say_status(publish);
  say_receipts(publish);
  return !ends_ || session_;
}

Desk::Hands Operating::hands() {
  return {.store = [this](const DeskBook& book) { store(book); },
          .exists =
              [this](const std::string& name) {
                const auto& fallback = options_.recorder.fallback;
                return is_taken(options_.recordings / name, fallback.empty() ? fallback : fallback / name,
                                desk_.over(), world_.disk);
              },
          .begin = [this](const UnderWay& recording) { begin(recording); },
          .stop =
              [this] {
                note_marks();
                if (session_) session_->stop();
              },
          .note =
              [this](NoteToRecord note) {
                note.at = time_.now;
                if (note.kind == NoteKind::kMark)
                  marks_.push_back(std::move(note));
                else if (session_)
                  session_->note(std::move(note));
              },
          .set_up = [this](const Request& request) { return set_up(request); },
          .asked_set_up = [this] { return set_up_->asked(); },
          .forget_set_up = [this] { set_up_->forget(); },
          .is_set_up_under_way = [this] { return is_set_up_under_way(); },
          .read_mark = [this](const Request& request) { return read_mark(request); }};
}

// A recorder that comes after a kill gives the numbers that its book does not know to other marks: none may
// be in the record by then.  A record that goes on elsewhere is not made to wait for the disk of the book.
void Operating::note_marks() {
  if (!session_ || marks_.empty()) return;
  const auto is_elsewhere = [this] {
    const auto status = session_->view().status;
    return status && status->fallback;
  };
  if (!desk_.is_written() && !is_elsewhere()) return;
  for (NoteToRecord& mark : std::exchange(marks_, {})) session_->note(std::move(mark));
}

void Operating::begin(const UnderWay& recording) {
  RecorderOptions options = options_.recorder;
  options.continues = has_samples_;
  options.folder = options_.recordings / recording.name;
  options.start = true;
  if (!options.fallback.empty()) options.fallback /= recording.name;
  options.scope.leaves_open = true;
  for (const Rest& rest : desk_.rests()) options.scope.not_these.emplace_back(rest.node, rest.epoch);
  options.scope.not_started_by = former_incarnations();
  options.first_incarnation = first_incarnation(recording, desk_.over());
  sync_us_.clear();
  differs_.clear();
  agreed_at_ = time_.now;
  options.complete = [this, recording](RecorderStatus& status) {
    status.recorder = recorder_;
    status.operable = true;
    status.name = recording.name;
    status.recording_s = 1e-6 * static_cast<double>(status.time_us - recording.began_us);
    status.marks = std::max(status.marks, recording.durable_marks);
    status.nodes = nodes_recorded_;
    if (const std::lock_guard lock(differs_mutex_); status.fault.empty()) status.fault = differs_;
  };
  marks_.clear();  // the desk says again those of a session before that may not be in the record
  session_ = world_.begin(std::move(options));
}

void Operating::look_after_recording() {
  if (!session_) {
    if (desk_.under_way() && time_.now - failed_at_ >= kAgain && !ends_) desk_.again();
    return;
  }
  const Session::View view = session_->view();
  nodes_recorded_ = static_cast<int>(std::ranges::count_if(
      view.report.node, [](const NodeReport& node) { return node.samples_recorded > 0; }));
  if (view.status) {
    const bool has_samples = std::ranges::any_of(view.report.node, &NodeReport::has_durable_samples);
    has_samples_ = has_samples_ || has_samples;
    if (!view.is_over) desk_.runs(has_samples, view.status->marks, time_.utc_us);
    follow_disk(view.status->state == RecorderState::kDiskFailing);
  }
  if (!view.is_over) return tell_who_differs();
  session_.reset();
  mark_readings_.forget();
  if (view.error.empty()) {
    desk_.marks_are_durable(view.report.marks);
    return finish(view.report);
  }
  warn(view.error);
  failed_at_ = time_.now;
  if (ends_) throw std::runtime_error(view.error);
  desk_.failed(view.error, view.status.has_value(), time_.utc_us);
}

// An epoch whose rest was fetched later has been told before: what is newer counts.
void Operating::add_to_report(const RecorderReport& one) {
  for (const NodeReport& node : one.node) {
    std::erase_if(report_.node, [&](const NodeReport& before) {
      return before.node == node.node && before.epoch == node.epoch;
    });
    report_.node.push_back(node);
  }
  report_.blocks_refused += one.blocks_refused;
  report_.rival_heartbeats += one.rival_heartbeats;
  report_.unsent += one.unsent;
  report_.foreign = one.foreign;
}

void Operating::finish(const RecorderReport& report) {
  const UnderWay recording = *desk_.under_way();
  has_samples_ = false;
  add_to_report(report);
  const std::vector<Rest> dropped = desk_.ended(
      receipts_of(report, {.name = recording.name,
                           .incarnation = report.incarnation,
                           .began_us = recording.began_us,
                           .ended_us = time_.utc_us,
                           .bytes = bytes_of_folder(options_.recordings / recording.name, world_.disk),
                           .marks = recording.marks,
                           .sync_us = sync_us_}),
      rests_of(report, recording.name), time_.utc_us, report.incarnation);
  ended_at_ = time_.now;
  for (const Rest& rest : dropped)
    warn("the rest of \"" + rest.recording + "\" at node " + std::to_string(rest.node) +
         " is not fetched: " + std::to_string(kMostRests) + " later ones wait for their nodes");
  status_at_ = receipts_at_ = {};
}

void Operating::hear_clock(std::span<const std::uint8_t> bytes) {
  const auto fit = decode_clock_fit(bytes);
  if (!fit || !session_ || !fit->is_known()) return;
  if (sync_us_.size() >= kMostNodes && !sync_us_.contains(fit->node)) return;
  double& largest = sync_us_[fit->node];
  largest = std::max(largest, 1e6 * fit->uncertainty_s);
}

/// For people: nodes that would measure by something else than the file that is led here; empty: none.
std::string Operating::who_differs() const {
  return heard_.who_differs(set_up_->crc32c(), set_up_->file().filename().string());
}

// Into the status that the session says, and into the record.
void Operating::tell_who_differs() {
  std::string who = set_up_ ? who_differs() : "";
  if (who.empty()) agreed_at_ = time_.now;
  // The last heartbeat may be from before a set-up that is just done.
  if (time_.now - agreed_at_ < kSettling) who.clear();
  const std::lock_guard lock(differs_mutex_);
  if (std::exchange(differs_, who) == who || who.empty()) return;
  session_->note({.kind = NoteKind::kAsked,
                  .a = static_cast<std::int64_t>(Operation::kVehicle),
                  .b = static_cast<std::int64_t>(RefusalReason::kNone),
                  .text = who,
                  .at = time_.now});
}

void Operating::warn(const std::string& sentence) const {
  if (options_.recorder.on_warning) options_.recorder.on_warning(sentence);
}

}  // namespace roadbalance

#include "host/recorder/control/operating.hpp"

#include <algorithm>
#include <charconv>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/recorder_status.hpp"
#include "host/recorder/clock_change.hpp"
#include "host/recorder/control/node_receipts.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kSettling{1000};
constexpr milliseconds kStatus{500};
constexpr milliseconds kReceipts{1000};

// "front, 2" -> "front" and "2".
std::vector<std::string> words_of(const std::string& list) {
  std::vector<std::string> words;
  for (std::size_t from = 0; from < list.size();) {
    const std::size_t to = std::min(list.find_first_of(", ", from), list.size());
    if (to > from) words.push_back(list.substr(from, to - from));
    from = to + 1;
  }
  return words;
}

// @throws ConfigError if it is none of these, nor a number where no names are known
std::int32_t number_of(const std::string& word, const std::vector<ExpectedNode>& all) {
  std::int32_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  const bool is_number = error == std::errc() && end == word.data() + word.size();
  std::string names;
  for (const ExpectedNode& node : all) {
    if (word == node.name || (is_number && number == node.number)) return node.number;
    names += (names.empty() ? "" : ", ") + (node.name.empty() ? std::to_string(node.number) : node.name);
  }
  if (all.empty() && is_number && number >= 1 && number <= kLastNode) return number;
  throw ConfigError("node " + word + ": there is none; allowed: " +
                    (all.empty() ? "numbers, for this recorder leads no vehicle file" : names));
}

}  // namespace

Operating::Operating(const OperateOptions& options, World world, Time time)
    : options_(options),
      world_(std::move(world)),
      folder_(options.recordings, world_.disk, [this](const std::string& sentence) { warn(sentence); }),
      time_(time),
      recorder_(static_cast<std::int64_t>(world_.seed % static_cast<std::uint64_t>(kRequestLimit - 1)) + 1),
      fetch_(
          options, world_.disk, world_.begin, folder_,
          [this](const std::string& sentence) { warn(sentence); }, time.now),
      controller_(callbacks(),
                  vehicle_.begin(options.vehicle, options.recordings, world_.seed, world_.disk,
                                 read_session_state(options.recordings, world_.disk), time.utc_us, time.now,
                                 [this](const std::string& sentence) { warn(sentence); })) {
  folder_.know_state();
  if (options.start) controller_.begin(*options.start, time.utc_us);
}

void Operating::take(std::string_view channel, std::span<const std::uint8_t> bytes, Time time) {
  set_time(time);
  if (channel == kRequestChannel) {
    if (const auto request = decode_request(bytes); request && !is_of_recordings(request->operation))
      controller_.take(*request, time.utc_us, {heard_.count(time.now), heard_.left(time.now)});
  } else if (channel.starts_with("RB_HEARTBEAT_")) {
    heard_.take(bytes, time.now);
    if (const auto beat = decode_heartbeat(bytes)) fetch_.take(*beat, time.now);
  } else if (channel.starts_with(kClockChannels)) {
    hear_clock(bytes);
  } else {
    vehicle_.take(channel, bytes, time.now);
  }
}

bool Operating::turn(bool stop_requested, Time time, const Publish& publish) {
  set_time(time);
  if (stop_requested && !std::exchange(ends_, true)) {
    fetch_.leave();
    controller_.end();
  }
  provide();
  look_after_recording();
  if (time_.now - written_again_at_ >= kAgain) {
    written_again_at_ = time_.now;
    controller_.write_again();
  }
  note_marks();
  if (!ends_)
    if (const auto fetched = fetch_.turn(controller_, time.now)) add_to_report(*fetched);
  if (const auto answer = vehicle_.turn(publish, time.utc_us, time.now)) controller_.was_set_up(*answer);
  for (const Answer& answer : controller_.answers()) (void)publish(kAnswerChannel, encode(answer));
  send_status(publish);
  send_receipts(publish);
  return !ends_ || session_;
}

SessionController::Callbacks Operating::callbacks() {
  return {
      .store = [this](const SessionState& state) { folder_.store(state); },
      .taken_by =
          [this](const std::string& name) {
            const auto& fallback = options_.recorder.fallback;
            return roadbalance::taken_by(options_.recordings / name,
                                         fallback.empty() ? fallback : fallback / name, controller_.past(),
                                         world_.disk);
          },
      .begin = [this](const ActiveRecording& recording) { begin(recording); },
      .stop =
          [this](const std::string& by) {
            note_marks();
            if (session_) session_->stop(by);
          },
      .choose = [this](const std::string& nodes) { return choose(nodes); },
      .note =
          [this](NoteToRecord note) {
            note.at = time_.now;
            if (note.kind == NoteKind::kMark)
              marks_.push_back(std::move(note));
            else if (session_)
              session_->note(std::move(note));
          },
      .set_up =
          [this](const Request& request) {
            return vehicle_.set_up(request, heard_.nodes(time_.now), time_.utc_us, time_.now);
          },
      .asked_set_up = [this] { return vehicle_.leading()->asked(); },
      .forget_set_up = [this] { vehicle_.leading()->forget(); },
      .is_set_up_under_way = [this] { return vehicle_.is_set_up_under_way(); },
      .read_mark =
          [this](const Request& request) { return vehicle_.read_mark(request, time_.utc_us, time_.now); }};
}

// Every node of the vehicle file, as far as this recorder is to record it; without one those of its command
// line.
std::vector<ExpectedNode> Operating::expected() const {
  const auto& ours = options_.recorder.nodes;
  std::vector<ExpectedNode> all;
  if (!vehicle_.leading()) {
    for (const std::int32_t number : ours) all.push_back({.number = number});
    return all;
  }
  for (const NodeConfig& node : vehicle_.leading()->vehicle().node)
    if (ours.empty() || std::ranges::find(ours, node.id) != ours.end())
      all.push_back({.number = node.id, .name = node.name});
  return all;
}

std::vector<ExpectedNode> Operating::expected_of(const std::vector<std::int32_t>& chosen) const {
  std::vector<ExpectedNode> all = expected();
  if (chosen.empty()) return all;
  std::vector<ExpectedNode> expected;
  for (const std::int32_t number : chosen) {
    const auto known = std::ranges::find(all, number, &ExpectedNode::number);
    expected.push_back(known == all.end() ? ExpectedNode{.number = number} : *known);
  }
  return expected;
}

ChosenNodes Operating::choose(const std::string& nodes) const {
  const std::vector<ExpectedNode> all = expected();
  ChosenNodes chosen;
  for (const std::string& word : words_of(nodes)) chosen.nodes.push_back(number_of(word, all));
  const std::vector<std::int32_t> there = heard_.nodes(time_.now);
  const auto is_there = [&there](std::int32_t node) { return std::ranges::find(there, node) != there.end(); };
  for (ExpectedNode& node : expected_of(chosen.nodes))
    if (!is_there(node.number)) chosen.missing.push_back(std::move(node));
  chosen.is_any_there = chosen.nodes.empty() || std::ranges::any_of(chosen.nodes, is_there);
  return chosen;
}

// A recorder that comes after a kill gives the numbers that its session state does not hold to other marks:
// none may be in the record by then.  A record that goes on elsewhere is not made to wait for the disk of
// that state.
void Operating::note_marks() {
  if (!session_ || marks_.empty()) return;
  const auto is_elsewhere = [this] {
    const auto status = session_->view().status;
    return status && status->fallback;
  };
  if (!controller_.is_written() && !is_elsewhere()) return;
  for (NoteToRecord& mark : std::exchange(marks_, {})) session_->note(std::move(mark));
}

void Operating::begin(const ActiveRecording& recording) {
  RecorderOptions options = options_.recorder;
  options.continues = has_samples_;
  options.folder = options_.recordings / recording.name;
  options.start = true;
  options.heard = heard_.heartbeats(time_.now);
  options.first_at_once = true;
  if (!recording.nodes.empty()) options.nodes = recording.nodes;
  options.expected = expected_of(recording.nodes);
  for (ExpectedNode& node : options.expected)
    node.is_missing =
        std::ranges::find(recording.missing, node_words(node.number, node.name)) != recording.missing.end();
  options.absent_before = recording.absence;
  if (!options.fallback.empty()) options.fallback /= recording.name;
  options.scope.leaves_open = true;
  for (const PendingEpoch& one : controller_.pending())
    options.scope.not_these.emplace_back(one.node, one.epoch);
  options.scope.not_started_by = fetch_.former_incarnations(controller_.past());
  options.first_incarnation = first_incarnation(recording, controller_.past());
  sync_us_.clear();
  differs_.clear();
  agreed_at_ = time_.now;
  clock_set_us_ = recording.clock_set_us;
  options.complete = [this, recording](RecorderStatus& status) {
    status.recorder = recorder_;
    status.operable = true;
    status.name = recording.name;
    status.recording_s = 1e-6 * static_cast<double>(status.time_us - recording.began_us - clock_set_us_);
    status.marks = std::max(status.marks, recording.durable_marks);
    status.nodes = nodes_recorded_;
    if (const std::lock_guard lock(differs_mutex_); status.fault.empty()) status.fault = differs_;
  };
  marks_.clear();  // the controller notes again those of a session before that may not be in the record
  session_ = world_.begin(std::move(options));
}

void Operating::set_time(const Time& time) {
  const auto passed = std::chrono::duration_cast<std::chrono::microseconds>((time.now - time_.now) +
                                                                            (time.slept - time_.slept));
  const std::int64_t change_us = time.utc_us - time_.utc_us - passed.count();
  time_ = time;
  if (std::abs(change_us) < kClockSet_us) return;
  controller_.clock_was_set(change_us);
  if (controller_.active()) clock_set_us_ = controller_.active()->clock_set_us;
}

void Operating::provide() {
  const auto nodes = static_cast<std::size_t>(heard_.count(time_.now));
  if (std::exchange(nodes_there_, nodes) != nodes) nodes_there_since_ = time_.now;
  if (session_ || nodes <= provided_for_ || time_.now - nodes_there_since_ < kSettling) return;
  world_.provide(provided_for_ = nodes);
}

void Operating::look_after_recording() {
  if (!session_) {
    if (controller_.active() && time_.now - failed_at_ >= kAgain && !ends_) controller_.again();
    return;
  }
  const Session::View view = session_->view();
  nodes_recorded_ = static_cast<int>(std::ranges::count_if(
      view.report.node, [](const NodeReport& node) { return node.samples_recorded > 0; }));
  if (view.status) {
    const bool has_samples = std::ranges::any_of(view.report.node, &NodeReport::has_durable_samples);
    has_samples_ = has_samples_ || has_samples;
    if (!view.is_over) controller_.runs(has_samples, view.status->marks, time_.utc_us);
    if (view.report.incarnation != 0) controller_.are_absent(view.report.absence);
    folder_.follow_disk(view.status->state == RecorderState::kDiskFailing,
                        !options_.recorder.fallback.empty(), time_.now);
  }
  if (!view.is_over) return report_who_differs();
  session_.reset();
  vehicle_.forget_marks();
  if (view.error.empty()) {
    controller_.marks_are_durable(view.report.marks);
    return finish(view.report);
  }
  warn(view.error);
  failed_at_ = time_.now;
  if (ends_) throw std::runtime_error(view.error);
  controller_.failed(view.error, view.status.has_value(), time_.utc_us);
}

// An epoch whose rest was fetched later was reported before: the newer report counts.
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
  const ActiveRecording recording = *controller_.active();
  const std::string stopped_by = recording.stop ? recording.stopped_by : kStoppedBySignal;
  has_samples_ = false;
  add_to_report(report);
  const std::vector<PendingEpoch> dropped = controller_.ended(
      receipts_of(report, {.name = recording.name,
                           .incarnation = report.incarnation,
                           .began_us = recording.began_us + recording.clock_set_us,
                           .ended_us = time_.utc_us,
                           .bytes = bytes_of_folder(options_.recordings / recording.name, world_.disk),
                           .marks = recording.marks,
                           .sync_us = sync_us_,
                           .stopped_by = stopped_by}),
      pending_of(report, recording.name), time_.utc_us, report.incarnation);
  fetch_.recording_ended(time_.now);
  for (const PendingEpoch& one : dropped)
    warn("the rest of \"" + one.recording + "\" at node " + std::to_string(one.node) +
         " is not fetched: " + std::to_string(kMostPendingEpochs) + " later ones wait for their nodes");
  status_at_ = receipts_at_ = {};
}

void Operating::hear_clock(std::span<const std::uint8_t> bytes) {
  const auto fit = decode_clock_fit(bytes);
  if (!fit || !session_ || !fit->is_known()) return;
  if (sync_us_.size() >= kMostNodes && !sync_us_.contains(fit->node)) return;
  double& largest = sync_us_[fit->node];
  largest = std::max(largest, 1e6 * fit->uncertainty_s);
}

// For people: nodes that would measure by something else than the file that is led here; empty: none.
std::string Operating::who_differs() const {
  const auto& leading = vehicle_.leading();
  return leading ? heard_.who_differs(leading->crc32c(), leading->file().filename().string()) : "";
}

// In the status that the session sends, and in the record.
void Operating::report_who_differs() {
  std::string who = who_differs();
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

// From its first status to its end the session sends the state itself, with what it has.
void Operating::send_status(const Publish& publish) {
  if (time_.now - status_at_ < kStatus || session_speaks()) return;
  status_at_ = time_.now;
  RecorderStatus status{
      .time_us = time_.utc_us, .recorder = recorder_, .nodes = heard_.count(time_.now), .operable = true};
  status.state = status.nodes > 0 ? RecorderState::kArmed : RecorderState::kIdle;
  if (const auto& recording = controller_.active()) {
    status.state = controller_.fault().empty() ? RecorderState::kRecording : RecorderState::kFault;
    status.name = recording->name;
    status.recording_s =
        1e-6 * static_cast<double>(status.time_us - recording->began_us - recording->clock_set_us);
    status.marks = recording->durable_marks;
  }
  status.fault = controller_.fault();
  const std::int64_t free = world_.disk.free_bytes(options_.recordings.c_str());
  status.bytes_free = std::max<std::int64_t>(0, free - options_.recorder.reserve_bytes);
  if (vehicle_.leading() && !controller_.active()) {
    status.seconds_left = static_cast<double>(status.bytes_free) / vehicle_.leading()->bytes_per_s();
    if (status.fault.empty()) status.fault = who_differs();
  }
  if (free >= 0 && status.bytes_free == 0 && !controller_.active()) status.state = RecorderState::kDiskFull;
  (void)publish(kRecorderChannel, encode(status));
  if (options_.recorder.on_alive) options_.recorder.on_alive(status);
}

void Operating::send_receipts(const Publish& publish) {
  if (time_.now - receipts_at_ < kReceipts) return;
  receipts_at_ = time_.now;
  if (!controller_.finished() || controller_.active()) return;
  for (const Receipt& receipt : controller_.finished()->receipt)
    (void)publish(kReceiptChannel, encode(receipt));
}

}  // namespace roadbalance

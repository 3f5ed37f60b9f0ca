#include "host/recorder/operate.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <stdexcept>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control.hpp"
#include "common/bus/operation.hpp"
#include "common/clock/clocks.hpp"
#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "host/recorder/desk.hpp"
#include "host/recorder/heard_nodes.hpp"
#include "host/recorder/receipts.hpp"
#include "host/recorder/recording_session.hpp"
#include "host/recorder/set_up.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kTurn{20};
constexpr milliseconds kStatus{500};
constexpr milliseconds kReceipts{1000};
constexpr milliseconds kAgain{1000};
constexpr milliseconds kSettling{1000};

std::int64_t utc_us() {
  using namespace std::chrono;
  return duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
}

std::int64_t random_number() {
  std::random_device device;
  return std::uniform_int_distribution<std::int64_t>(1, kRequestLimit - 1)(device);
}

void append(RecorderReport& all, const RecorderReport& one) {
  all.node.insert(all.node.end(), one.node.begin(), one.node.end());
  all.blocks_refused += one.blocks_refused;
  all.rival_heartbeats += one.rival_heartbeats;
  all.unsent += one.unsent;
  all.foreign = one.foreign;
}

// The desk on its bus, and its hands.
class Operating {
 public:
  explicit Operating(const OperateOptions& options)
      : options_(options),
        claim_(claim_desk_book(options.recordings)),
        recorder_(random_number()),
        bus_(options.recorder.url),
        desk_(hands(), with_vehicle(read_desk_book(options.recordings))) {
    bus_.subscribe(kRequestChannel, [this](std::string_view, auto bytes) {
      if (const auto request = decode_request(bytes); request && !is_of_recordings(request->operation))
        desk_.take(*request, utc_us(), heard_.count(WallClock::now()));
    });
    bus_.subscribe("RB_HEARTBEAT_.*",
                   [this](std::string_view, auto bytes) { heard_.take(bytes, WallClock::now()); });
    bus_.subscribe("RB_CLOCK_.*", [this](std::string_view, auto bytes) { hear_clock(bytes); });
    if (set_up_) listen_for_set_up();
    if (options.start) desk_.begin(*options.start, utc_us());
  }

  /// False: told to stop, and nothing is left to be done.
  bool turn(bool told_to_stop) {
    bus_.handle(kTurn);
    if (told_to_stop && !std::exchange(ends_, true)) desk_.end();
    look_after_recording();
    if (set_up_)
      if (const auto answer = set_up_->turn(publish_, utc_us(), WallClock::now())) desk_.was_set_up(*answer);
    for (const Answer& answer : desk_.answers()) (void)bus_.publish(kAnswerChannel, encode(answer));
    const WallTime now = WallClock::now();
    if (now - status_at_ >= kStatus && !session_speaks()) say_status(now);
    if (now - receipts_at_ >= kReceipts) say_receipts(now);
    return !ends_ || session_;
  }

  RecorderReport report() const { return report_; }

 private:
  // Before the desk, which goes on with what the book has under way: a vehicle file that is broken must not
  // end that.
  DeskBook with_vehicle(DeskBook book) {
    if (options_.vehicle.empty()) return book;
    try {
      set_up_.emplace(options_.vehicle, options_.recordings);
    } catch (const std::exception& error) {
      if (!book.under_way) throw;
      no_set_up_ = error.what() + std::string(": mend the file and start rb-recorder again");
      warn("goes on without its vehicle file: " + no_set_up_);
    }
    return book;
  }

  void warn(const std::string& sentence) const {
    if (options_.recorder.on_warning) options_.recorder.on_warning(sentence);
  }

  void listen_for_set_up() {
    bus_.subscribe("RB_REPLY_.*", [this](std::string_view, auto bytes) {
      if (const auto reply = decode_reply(bytes)) set_up_->take(*reply);
    });
    bus_.subscribe("RB_PREVIEW_.*", [this](std::string_view, auto bytes) {
      if (accept(bytes, preview_) == Refusal::kNone && preview_.kind == BlockKind::kScan)
        set_up_->take(decode_scan(preview_), WallClock::now());
    });
  }

  Desk::Hands hands() {
    return {.store = [this](const DeskBook& book) { write_desk_book(options_.recordings, book); },
            .exists = [this](const std::string& name) { return path_exists(options_.recordings / name); },
            .begin = [this](const UnderWay& recording) { begin(recording); },
            .stop =
                [this] {
                  if (session_) session_->stop();
                },
            .note =
                [this](NoteToRecord note) {
                  if (session_) session_->note(std::move(note));
                },
            .set_up =
                [this](const Request& request) {
                  if (set_up_)
                    return set_up_->take(request, heard_.nodes(WallClock::now()), utc_us(), WallClock::now());
                  return Answer{.asker = request.asker,
                                .request = request.request,
                                .time_us = utc_us(),
                                .operation = request.operation,
                                .state = AnswerState::kRefused,
                                .reason = RefusalReason::kNotSupported,
                                .node = request.node,
                                .channel = request.channel,
                                .text = no_set_up_};
                },
            .is_set_up_under_way = [this] { return set_up_ && set_up_->is_under_way(); }};
  }

  void begin(const UnderWay& recording) {
    RecorderOptions options = options_.recorder;
    options.folder = options_.recordings / recording.name;
    options.start = true;
    if (!options.fallback.empty()) options.fallback /= recording.name;
    sync_us_.clear();
    differs_.clear();
    agreed_at_ = WallClock::now();
    session_ = std::make_unique<RecordingSession>(
        std::move(options), [recorder = recorder_, recording, this](RecorderStatus& status) {
          status.recorder = recorder;
          status.operable = true;
          status.name = recording.name;
          status.recording_s = 1e-6 * static_cast<double>(utc_us() - recording.began_us);
          status.marks = std::max(status.marks, recording.durable_marks);
          status.nodes = nodes_recorded_;
          if (const std::lock_guard lock(differs_mutex_); status.fault.empty()) status.fault = differs_;
        });
  }

  void look_after_recording() {
    const WallTime now = WallClock::now();
    if (!session_) {
      if (desk_.under_way() && now - failed_at_ >= kAgain && !ends_) desk_.again();
      return;
    }
    const RecordingSession::View view = session_->view();
    nodes_recorded_ = static_cast<int>(std::ranges::count_if(
        view.report.node, [](const NodeReport& node) { return node.samples_recorded > 0; }));
    if (view.status) {
      incarnation_ = view.status->incarnation;
      if (!view.is_over) desk_.runs(nodes_recorded_, view.status->marks, utc_us());
    }
    if (!view.is_over) return tell_who_differs();
    session_.reset();
    if (view.error.empty()) return finish(view.report);
    warn(view.error);
    failed_at_ = now;
    if (ends_) throw std::runtime_error(view.error);
    desk_.failed(view.error, view.status.has_value(), utc_us());
  }

  void finish(const RecorderReport& report) {
    const UnderWay& recording = *desk_.under_way();
    append(report_, report);
    const std::int64_t now_us = utc_us();
    desk_.ended(receipts_of(report, {.name = recording.name,
                                     .incarnation = incarnation_,
                                     .began_us = recording.began_us,
                                     .ended_us = now_us,
                                     .bytes = bytes_of_folder(options_.recordings / recording.name),
                                     .marks = recording.marks,
                                     .sync_us = sync_us_}),
                now_us);
    status_at_ = receipts_at_ = {};
  }

  void hear_clock(std::span<const std::uint8_t> bytes) {
    const auto fit = decode_clock_fit(bytes);
    if (!fit || !session_ || fit->state == ClockState::kAcquire) return;
    if (sync_us_.size() >= kMostNodes && !sync_us_.contains(fit->node)) return;
    double& largest = sync_us_[fit->node];
    largest = std::max(largest, 1e6 * fit->uncertainty_s);
  }

  /// For people: nodes that would measure by something else than the file that is led here; empty: none.
  std::string who_differs() const {
    return heard_.who_differs(set_up_->crc32c(), set_up_->file().filename().string());
  }

  // Into the status that the session says, and into the record.
  void tell_who_differs() {
    std::string who = set_up_ ? who_differs() : "";
    const WallTime now = WallClock::now();
    if (who.empty()) agreed_at_ = now;
    // The last heartbeat may be from before a set-up that is just done.
    if (now - agreed_at_ < kSettling) who.clear();
    const std::lock_guard lock(differs_mutex_);
    if (std::exchange(differs_, who) == who || who.empty()) return;
    session_->note({.kind = NoteKind::kAsked,
                    .a = static_cast<std::int64_t>(Operation::kVehicle),
                    .b = static_cast<std::int64_t>(RefusalReason::kNone),
                    .text = who});
  }

  // From its first word to its end the session says the state itself, with what it knows.
  bool session_speaks() const { return session_ && session_->view().status; }

  void say_status(WallTime now) {
    status_at_ = now;
    RecorderStatus status{
        .time_us = utc_us(), .recorder = recorder_, .nodes = heard_.count(now), .operable = true};
    status.state = status.nodes > 0 ? RecorderState::kArmed : RecorderState::kIdle;
    if (const auto& recording = desk_.under_way()) {
      status.state = desk_.fault().empty() ? RecorderState::kRecording : RecorderState::kFault;
      status.name = recording->name;
      status.recording_s = 1e-6 * static_cast<double>(status.time_us - recording->began_us);
      status.marks = recording->durable_marks;
    }
    status.fault = desk_.fault();
    const std::int64_t free = kernel_disk().free_bytes(options_.recordings.c_str());
    status.bytes_free = std::max<std::int64_t>(0, free - options_.recorder.reserve_bytes);
    if (set_up_ && !desk_.under_way()) {
      status.seconds_left = static_cast<double>(status.bytes_free) / set_up_->bytes_per_s();
      if (status.fault.empty()) status.fault = who_differs();
    }
    if (free >= 0 && status.bytes_free == 0 && !desk_.under_way()) status.state = RecorderState::kDiskFull;
    (void)bus_.publish(kRecorderChannel, encode(status));
    if (options_.recorder.on_alive) options_.recorder.on_alive(status);
  }

  void say_receipts(WallTime now) {
    receipts_at_ = now;
    if (!desk_.finished() || desk_.under_way()) return;
    for (const Receipt& receipt : desk_.finished()->receipt)
      (void)bus_.publish(kReceiptChannel, encode(receipt));
  }

  const OperateOptions& options_;
  const File claim_;
  const std::int64_t recorder_;
  Bus bus_;
  HeardNodes heard_{options_.recorder.nodes};
  std::map<std::int32_t, double> sync_us_;
  std::optional<SetUp> set_up_;
  std::string no_set_up_ = "this recorder leads no vehicle file: start rb-recorder with --vehicle FILE";
  SealedBlock preview_;
  const Publish publish_ = [this](const std::string& channel, std::span<const std::uint8_t> bytes) {
    return bus_.publish(channel, bytes);
  };
  std::atomic<int> nodes_recorded_ = 0;  // before the session, whose thread reads it
  std::mutex differs_mutex_;
  WallTime agreed_at_{};
  std::string differs_;  // who measures by another file, for the session
  std::unique_ptr<RecordingSession> session_;
  RecorderReport report_;
  std::int64_t incarnation_ = 0;
  bool ends_ = false;
  WallTime failed_at_{}, status_at_{}, receipts_at_{};
  Desk desk_;  // last: it may have its hands do something at once
};

}  // namespace

RecorderReport operate(std::stop_token stop, const OperateOptions& options) {
  create_folders(options.recordings);
  Operating operating(options);
  while (operating.turn(stop.stop_requested())) continue;
  return operating.report();
}

}  // namespace roadbalance

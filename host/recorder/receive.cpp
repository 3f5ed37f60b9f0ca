#include "host/recorder/receive.hpp"

#include <algorithm>
#include <map>
#include <random>
#include <stdexcept>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/results.hpp"
#include "common/clock/utc.hpp"
#include "host/recorder/alarm_watch.hpp"
#include "host/recorder/incarnation.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kBusWait{2};  // longest wait for the bus: bounds the delay of an acknowledgement
constexpr milliseconds kReport{200};
constexpr milliseconds kFirstReport{20};  // until the first samples are on the disk: somebody waits for them
constexpr milliseconds kStatus{500};
constexpr milliseconds kLastWords{50};  // after the release: answers of the last acks
constexpr milliseconds kStoreAgain{1000};

RecorderLinkOptions link_options(const RecorderOptions& options) {
  return {.start = options.start,
          .nodes = options.nodes,
          .heard = options.heard,
          .end_with_nodes = options.end_with_nodes,
          .patience = options.patience,
          .seed = std::random_device{}(),
          .scope = options.scope,
          .expected = options.expected,
          .absent_before = options.absent_before,
          .utc_us = utc_us()};
}

// The link on its bus.
class Reception {
 public:
  Reception(const RecorderOptions& options, const Incarnation& incarnation, const RecordState& recovered,
            Out<ClockPeer> peers)
      : options_(options),
        incarnation_folder_(incarnation.folder),
        bus_(options.url, {.hears_all = true}),
        link_(link_options(options), incarnation.number, recovered),
        peers_(std::move(peers)),
        alarms_(incarnation.number) {
    reserve_heap_for(nodes_provided_for_);  // before they are commanded to begin
    // First: that a node has a clock of its own is announced before its blocks are handed on.
    bus_.subscribe("RB_HEARTBEAT_.*", [this](std::string_view, auto bytes) { announce_clock(bytes); });
    for (const char* channels : {"RB_HEARTBEAT_.*", "RB_BLOCK_.*", "RB_REPLY_.*"})
      bus_.subscribe(channels, [this](std::string_view channel, auto bytes) {
        link_.take(channel, bytes, WallClock::now());
      });
    if (!options_.sends_state) return;  // it fetches a rest beside the recording that is watched
    watch<Heartbeat>("RB_HEARTBEAT_.*", decode_heartbeat);
    watch<Level>(kLevelChannel, decode_level);
    watch<Balance>(kBalanceChannel, decode_balance);
    watch<ClockFit>("RB_CLOCK_.*", decode_clock_fit);
  }

  RecorderLink& link() { return link_; }

  /// The end of each alarm that is on; if the recording goes on without us they do, too, and the next
  /// recorder notes it.
  std::vector<AlarmNote> last_alarm_notes(bool leaves) {
    return leaves ? alarms_.due(WallClock::now()) : alarms_.finish(WallClock::now());
  }

  /// One turn: takes what has arrived and has become durable, and sends what is due.
  WriteBatch turn(In<WriterNews>& news) {
    bus_.handle(kBusWait);
    const WallTime now = WallClock::now();
    while (const auto from_writer = news.receive_for(milliseconds(0))) take(*from_writer, now);
    raise_incarnation_if_needed(now);
    link_.turn(now, publish_);
    if (nodes_provided_for_ < link_.nodes()) {
      nodes_provided_for_ = link_.nodes();
      reserve_heap_for(nodes_provided_for_);
    }
    for (const auto& sentence : link_.warnings()) warn(sentence);
    for (const auto& sentence : bus_.other_versions()) warn(sentence);
    if (now - status_at_ >= kStatus) send_status(now);
    WriteBatch batch = batches_.take(link_, now);
    // A disk that fails takes no notes: they would only fill the memory, and the alarm keeps till then.
    if (status_.state != RecorderState::kDiskFailing && status_.state != RecorderState::kDiskFull)
      batch.alarm_notes = alarms_.due(now);
    return batch;
  }

  void farewell() {
    link_.farewell(publish_);
    bus_.handle(kLastWords);
  }

 private:
  template <typename Message, typename Decode>
  void watch(const char* channels, Decode decode) {
    bus_.subscribe(channels, [this, decode](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const std::optional<Message> message = decode(bytes)) alarms_.take(*message, WallClock::now());
    });
  }

  void take(const WriterNews& news, WallTime now) {
    for (const auto& mark : news.marks) link_.durable(mark, now);
    link_.set_credit_open(news.wants_credit);
    status_ = news.status;
    writer_turns_ = true;
  }

  // A disk that does not take the number now may take it later, and a file that holds no number may be
  // mended; until then that node obeys no recorder.
  void raise_incarnation_if_needed(WallTime now) {
    if (link_.obeyed_higher() == 0 || now < store_at_) return;
    const auto& folder = status_.fallback ? options_.fallback : incarnation_folder_;
    try {
      link_.set_incarnation(raise_incarnation(folder, link_.obeyed_higher()));
      refusal_is_reported_ = false;
    } catch (const std::runtime_error& error) {
      if (!std::exchange(refusal_is_reported_, true))
        warn("a node obeyed incarnation " + std::to_string(link_.obeyed_higher()) +
             ", and a higher one cannot be stored: " + error.what() + "; until then it obeys nobody");
      store_at_ = now + kStoreAgain;
    }
  }

  void announce_clock(std::span<const std::uint8_t> bytes) {
    const auto beat = decode_heartbeat(bytes);
    const auto& ours = options_.nodes;
    if (!beat || beat->time_base != TimeBase::kOwn ||
        (!ours.empty() && std::find(ours.begin(), ours.end(), beat->node) == ours.end()) ||
        !options_.scope.has({beat->node, beat->epoch}))
      return;
    (void)peers_.try_send({.node = beat->node,
                           .epoch = beat->epoch,
                           .address = {beat->clock_address, beat->clock_port}});  // the next one comes soon
  }

  // A page, which hears only messages that it can read, has it from the recorder's status.
  std::string about_other_versions(WallTime now) {
    for (const std::int32_t node : bus_.nodes_of_other_versions()) {
      alarms_.take_other_version(node, now);
      if (other_versions_.contains(node) || other_versions_.size() < kMostNamed) other_versions_[node] = now;
    }
    std::erase_if(other_versions_, [&](const auto& one) { return now - one.second >= AlarmWatch::kSilence; });
    if (other_versions_.empty()) return "";
    std::string nodes;
    for (const auto& one : other_versions_) nodes += (nodes.empty() ? "" : ", ") + std::to_string(one.first);
    const bool one = other_versions_.size() == 1;
    return (one ? "node " : "nodes ") + nodes + (one ? " speaks" : " speak") +
           " another version of the wire: install the same release everywhere";
  }

  void send_status(WallTime now) {
    status_at_ = now;
    status_.time_us = utc_us();
    link_.fill(status_);
    status_.recorder = recorder_;
    status_.name = options_.folder.filename().string();
    status_.recording_s = std::chrono::duration<double>(now - began_).count();
    status_.nodes = static_cast<std::int32_t>(link_.nodes());
    status_.refused_datagrams += bus_.dropped();
    if (options_.complete) options_.complete(status_);
    if (!options_.sends_state) return;
    alarms_.set_owner(link_.incarnation());
    alarms_.turn(now);
    alarms_.take(status_, now);
    RecorderStatus sent = status_;
    if (const std::string other = about_other_versions(now); sent.fault.empty()) sent.fault = other;
    (void)publish_(kRecorderChannel, encode(sent));
    // We turn, that is seen here; the writer turns if it has sent something since.
    if (std::exchange(writer_turns_, false) && options_.on_alive) options_.on_alive(status_);
  }

  void warn(const std::string& sentence) const {
    if (options_.on_warning) options_.on_warning(sentence);
  }

  const RecorderOptions& options_;
  const std::filesystem::path incarnation_folder_;
  Bus bus_;
  RecorderLink link_;
  Out<ClockPeer> peers_;
  RecorderStatus status_;
  BatchMaker batches_;
  AlarmWatch alarms_;
  static constexpr std::size_t kMostNamed = 8;       // numbers of nodes can be anything
  std::map<std::int32_t, WallTime> other_versions_;  // node and when it was heard last
  std::size_t nodes_provided_for_ = options_.heard.size();
  bool writer_turns_ = false;
  const std::int64_t recorder_ = static_cast<std::int64_t>(std::random_device{}()) + 1;
  const WallTime began_ = WallClock::now();
  WallTime status_at_{};
  WallTime store_at_{};
  bool refusal_is_reported_ = false;
  const Publish publish_ = [this](const std::string& channel, std::span<const std::uint8_t> bytes) {
    return bus_.publish(channel, bytes);
  };
};

}  // namespace

void receive(std::stop_token stop, const RecorderOptions& options, const Incarnation& incarnation,
             const RecordState& recovered, Out<WriteBatch> batches, In<WriterNews> news, Out<ClockPeer> peers,
             RecorderReport& report) {
  Reception reception(options, incarnation, recovered, std::move(peers));
  RecorderLink& link = reception.link();
  WallTime reported_at{};
  bool leaves = false, has_samples = false;
  for (bool over = false; !over;) {
    // Asked first: a writer that fails closes `news` and only then stops the threads here.  The nodes are not
    // meant: they go on, keep what is not durable and wait for the next recorder.
    const bool stop_requested = stop.stop_requested();
    auto batch = reception.turn(news);
    if (news.finished()) break;
    if (batch.has_content() && !batches.send(std::move(batch))) break;
    leaves = options.leave.stop_requested();
    if (leaves) break;
    const WallTime now = WallClock::now();
    if (stop_requested) link.stop(now, options.stopped_by ? options.stopped_by() : kStoppedBySignal);
    over = link.over(now);
    if (options.on_progress && (over || now - reported_at >= (has_samples ? kReport : kFirstReport))) {
      RecorderReport report_now = link.report();
      has_samples = std::ranges::any_of(report_now.node, &NodeReport::has_durable_samples);
      report_now.absence = link.absences(now, utc_us());
      options.on_progress(report_now);
      reported_at = now;
    }
  }
  if (!leaves) link.finish(WallClock::now());
  WriteBatch last = BatchMaker::take_last(link);
  last.alarm_notes = reception.last_alarm_notes(leaves);
  if (last.has_content()) (void)batches.send(std::move(last));
  reception.farewell();
  report = link.report();
  report.absence = link.absences(WallClock::now(), utc_us());
}

}  // namespace roadbalance

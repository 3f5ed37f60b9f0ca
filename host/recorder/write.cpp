#include "host/recorder/write.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "common/clock/utc.hpp"
#include "host/recorder/power/power_watch.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kWriteWait{50};  // longest wait: the supply is read so often
constexpr milliseconds kNewsPeriod{200};

class Writing {
 public:
  Writing(RecordingStore& store, const WriteOptions& options, Out<WriterNews> news)
      : store_(store), options_(options), out_(std::move(news)) {
    set_clocks();
    store_.begin();
  }

  milliseconds patience() const {
    return std::clamp(store_.time_left(WallClock::now()), milliseconds(0), kWriteWait);
  }

  void turn(const std::optional<WriteBatch>& batch, In<RecordEvent>& events) {
    set_clocks();
    const WallTime now = WallClock::now();
    // A fit counts for the blocks behind it in the record: what was known when these came stands before them.
    while (const auto event = events.receive_for(milliseconds(0))) store_.append(*event, now);
    if (batch) append(store_, *batch, now);
    take_notes();
    if (options_.power) watch_power(now);
    const bool commits = store_.commit_is_due(now);
    if (commits) take(store_.commit(now), now);
    send_news();
    if (!commits) store_.maintain();
  }

  void close() {
    take_notes();
    const WallTime now = WallClock::now();
    take(store_.close(now), now);
    send_news();
  }

 private:
  void take_notes() {
    if (!options_.notes) return;
    for (const NoteToRecord& note : options_.notes())
      store_.note(note.kind, note.a, note.b, note.text, WallClock::now() - note.at);
  }

  void set_clocks() {
    const MachineClock::duration slept = MachineClock::slept();
    store_.set_clocks(utc_us(), to_ns(MachineClock::now()), slept);
  }

  void watch_power(WallTime now) {
    switch (power_.take(options_.power->is_good(), now)) {
      case PowerWatch::Event::kNone:
        return;
      case PowerWatch::Event::kLost:
        store_.note(NoteKind::kPowerLost, 0, 0, options_.power->name());
        take(store_.seal(now), now);
        return warn("the supply " + options_.power->name() + " is gone; recording goes on");
      case PowerWatch::Event::kReturned:
        store_.note(NoteKind::kPowerReturned, 0, 0, options_.power->name());
        return warn("the supply " + options_.power->name() + " is back");
      case PowerWatch::Event::kUnreadable:
        store_.note(NoteKind::kPowerUnknown, 1, 0, options_.power->name());
        return warn("the supply " + options_.power->name() + " cannot be read; recording goes on");
      case PowerWatch::Event::kReadable:
        store_.note(NoteKind::kPowerUnknown, 0, 0, options_.power->name());
        return warn("the supply " + options_.power->name() + " can be read again");
    }
  }

  /// @param began  before the commit that made these durable
  void take(std::vector<DurableMark> marks, WallTime began) {
    if (marks.empty()) return;
    sync_s_ = std::chrono::duration<double>(WallClock::now() - began).count();
    longest_sync_s_ = std::max(longest_sync_s_, sync_s_);
    news_.marks.insert(news_.marks.end(), marks.begin(), marks.end());
    sent_at_ = {};
  }

  // Never waits for the reader, who may be waiting for us.
  void send_news() {
    for (const auto& warning : store_.warnings()) warn(warning);
    if (WallClock::now() - sent_at_ < kNewsPeriod) return;
    news_.wants_credit = store_.wants_credit();
    store_.fill(news_.status);
    news_.status.on_battery = power_.on_battery();
    news_.status.power_unknown = power_.is_unreadable();
    news_.status.sync_s = sync_s_;
    news_.status.longest_sync_s = longest_sync_s_;
    if (!out_.try_send(news_)) return;
    news_.marks.clear();
    sent_at_ = WallClock::now();
  }

  void warn(const std::string& sentence) const {
    if (options_.on_warning) options_.on_warning(sentence);
  }

  RecordingStore& store_;
  const WriteOptions& options_;
  Out<WriterNews> out_;
  PowerWatch power_;
  WriterNews news_;
  WallTime sent_at_{};
  double sync_s_ = 0;
  double longest_sync_s_ = 0;
};

}  // namespace

void write_record(RecordingStore& store, const WriteOptions& options, In<WriteBatch> batches,
                  In<RecordEvent> events, Out<WriterNews> news) {
  Writing writing(store, options, std::move(news));
  while (!batches.finished()) {
    const auto batch = batches.receive_for(writing.patience());
    writing.turn(batch, events);
  }
  writing.close();
  if (const auto failure = store.failure())
    throw std::runtime_error(*failure + "; the nodes keep what is not on the disk");
}

}  // namespace roadbalance

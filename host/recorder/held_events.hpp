#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/link/epoch_receiver.hpp"
#include "common/record/record_state.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// Anything that the record keeps beside blocks and notes: clock exchanges and fits.
struct RecordEvent {
  std::string channel;
  std::vector<std::uint8_t> bytes;
  std::int64_t dropped_before{};  ///< events since the one before that found no room on their way here
};

/// The events that the record has been given since it was last durable, in order, and how many of them have
/// been appended: after a failed write or sync they are written again, so that nothing depends on the nodes
/// still having them.
///
/// Memory: blocks are bounded by the nodes' credit, other events by 16 MiB, notes of devices, of alarms and
/// of what was asked by kMostNotes; other notes are few.  Dropped events and notes are counted.  Memory once
/// used is kept.
class HeldEvents {
 public:
  static constexpr int kMostNotes = 1000;

  struct Event {
    std::string_view channel;
    std::span<const std::uint8_t> data;
    std::int64_t timestamp_us = 0;
  };

  /// @param appended  to the record's writer so far
  explicit HeldEvents(std::int64_t appended = 0) : appended_before_(appended) {}

  /// A block waits for the disk from now on; push() follows.
  void await(const SealedBlock& block, WallTime now);
  void push(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t timestamp_us);
  /// Held if there is memory for it.
  void push(const RecordEvent& event, std::int64_t timestamp_us);
  /// @return false: there is no memory for it
  bool push(const Note& note, std::int64_t timestamp_us);

  bool empty() const { return places_.empty(); }
  std::size_t bytes() const { return bytes_.size(); }
  /// Calls this with each, in order.
  void for_each(const std::function<void(const Event&)>& call) const;

  /// All of them have been appended.
  bool is_caught_up() const { return written_ == places_.size(); }
  /// The next to be appended.  Valid until the next push.
  Event next() const { return at(written_); }
  /// So it was.
  void advance() { ++written_; }
  /// Only these are on the disk; the others are appended again.
  /// @param durable  as RecordWriter counts them
  void go_back_to(std::int64_t durable);
  /// All are appended again, to another folder; the journal's entries for the first one are dropped.
  /// @param appended  to that folder's writer
  void begin_anew(std::int64_t appended);
  /// All are on the disk.
  /// @return the last sequence of each epoch that waited
  std::map<NodeEpoch, std::int64_t> clear(std::int64_t appended);

  /// The last sequence of each epoch whose blocks are held.
  const std::map<NodeEpoch, std::int64_t>& pending() const { return pending_; }
  std::int64_t blocks() const { return blocks_; }
  /// When the first of them came.
  WallTime oldest() const { return oldest_; }
  /// An end is among them: its node waits for it.
  bool is_urgent() const { return is_urgent_; }
  /// A note is among them that begins a segment of a recording that has blocks.
  bool has_news() const { return has_news_; }

  struct Dropped {
    std::int64_t events = 0, notes = 0;
  };
  /// Since the last call.
  Dropped take_dropped() { return std::exchange(dropped_, {}); }

 private:
  struct Place {
    std::size_t offset = 0;
    std::size_t channel_bytes = 0;
    std::size_t data_bytes = 0;
    std::int64_t timestamp_us = 0;
  };
  Event at(std::size_t index) const;
  bool has_memory_for(NoteKind kind);
  /// Forgets the others.  @return how many
  std::int64_t keep_if(const std::function<bool(std::size_t index, const Event&)>& keeps);

  std::vector<std::uint8_t> bytes_;
  std::vector<Place> places_;
  std::size_t written_ = 0;                    // appended to the writer
  std::int64_t appended_before_;               // the writer's count when there were none
  std::map<NodeEpoch, std::int64_t> pending_;  // the last sequence
  std::int64_t blocks_ = 0;
  WallTime oldest_{};
  bool is_urgent_ = false;
  int notes_ = 0;  // of those that may be dropped
  bool has_news_ = false;
  Dropped dropped_;
};

}  // namespace roadbalance

#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/bus/publish.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/clock/clocks.hpp"
#include "common/link/receiver.hpp"
#include "common/record/record_state.hpp"
#include "host/recorder/device_notes.hpp"
#include "host/recorder/epoch_scope.hpp"
#include "host/recorder/foreign_nodes.hpp"
#include "host/recorder/node_control.hpp"
#include "host/recorder/tally.hpp"

namespace roadbalance {

/// Everything of a node epoch through `sequence` is on the disk.
struct DurableMark {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t sequence = 0;
};

/// What the link counts, and hears from the nodes, of losses and how they were mended, for the journal.
struct LinkCounters {
  std::int64_t refused = 0;
  std::int64_t rivals = 0;
  std::int64_t unsent = 0;
  std::map<NodeEpoch, NodeLosses> node;
};

struct RecorderLinkOptions {
  bool start = true;                ///< start each node that is claimed
  std::vector<std::int32_t> nodes;  ///< record only these; empty: every node heard
  bool end_with_nodes = false;      ///< be over when each of `nodes` has ended and all of it is on the disk
  /// After a stop: how long to wait without any news for the nodes' last blocks.
  std::chrono::milliseconds patience{10'000};
  std::uint64_t seed = 1;  ///< of request numbers, which two recorders must not share
  EpochScope scope{};
};

/// The recorder's half of the bus without a bus: datagrams in; deliveries, acknowledgements and commands out.
/// An epoch is received from when it obeys us on: until then it is another recorder's.
/// A pure state machine; time comes in with every call.
class RecorderLink {
 public:
  /// @param recovered  what the record holds: it is not taken again
  RecorderLink(RecorderLinkOptions options, std::int64_t incarnation, const RecordState& recovered);

  /// A datagram of any channel; those of other channels than heartbeat, block and reply are passed over.
  void take(std::string_view channel, std::span<const std::uint8_t> bytes, WallTime now);
  void durable(const DurableMark& mark, WallTime now);
  /// False: no new credit, because the disk fails or is full; the nodes keep what they have.
  void set_credit_open(bool open);
  /// Says what is due: acknowledgements and commands.
  void turn(WallTime now, const Publish& publish);
  /// What the record gets next, since the last call.
  std::vector<Delivery> deliveries();
  /// What devices of nodes that are recorded here have counted, since the last call.
  std::vector<DeviceNote> device_notes() { return std::exchange(device_notes_, {}); }

  /// From now on nodes are stopped and their ends waited for.
  void stop(WallTime now);
  /// Nothing more is to be waited for, and the nodes know that what they sent is durable, or are silent.
  bool over(WallTime now);
  /// It is over: the last deliveries, with the crash of each epoch that will not go on.
  void finish(WallTime now);
  /// Releases every node owned, for the end.
  void farewell(const Publish& publish);

  /// An incarnation above our own that a node obeys (a recorder whose clock was ahead); 0: none.  The caller
  /// stores a higher one and sets it.
  std::int64_t obeyed_higher() const { return control_.obeyed_higher(); }
  std::int64_t incarnation() const { return receiver_.incarnation(); }
  std::size_t nodes() const { return receiver_.nodes(); }  ///< that have been heard
  void set_incarnation(std::int64_t incarnation);

  RecorderReport report() const;
  LinkCounters counters() const;
  /// Fills in what the link side of the recorder knows.
  void fill(RecorderStatus& status) const;
  /// Sentences for people, since the last call.
  std::vector<std::string> warnings() { return foreign_.sentences(); }

 private:
  struct Heard {
    WallTime at{};
    std::int64_t base = 0, next = 0;  ///< sequences that it held then: from base up to next
    DeviceNotes devices{};
  };
  void count_silence_to(WallTime now);
  void hear(const Heartbeat& heartbeat, WallTime now);
  void on_heartbeat(std::span<const std::uint8_t> bytes, WallTime now);
  void on_block(std::span<const std::uint8_t> bytes, WallTime now);
  void on_reply(std::span<const std::uint8_t> bytes);
  bool is_ours(const NodeEpoch& key) const;
  void set_apart(const Heartbeat& heartbeat);
  bool holds_blocks(NodeEpoch key) const;
  bool has_ended(NodeEpoch key) const;
  bool is_superseded(NodeEpoch key, WallTime now) const;
  bool all_ended(WallTime now) const;
  bool expected_have_ended(WallTime now) const;
  bool nodes_have_let_go(WallTime now) const;
  void send(const Command& command, const Publish& publish);

  const RecorderLinkOptions options_;
  Receiver receiver_;
  NodeControl control_;
  Tally tally_;
  ForeignNodes foreign_;
  std::map<NodeEpoch, Heard> heard_;  // the last heartbeat of each epoch being received
  std::set<NodeEpoch> former_;        // of recordings before, whoever leads them by now
  std::optional<WallTime> listening_since_;
  std::optional<WallTime> called_at_;  // last
  std::vector<Delivery> delivered_;
  std::size_t tallied_ = 0;  // of delivered_
  std::vector<DeviceNote> device_notes_;
  bool credit_open_ = true;
  SealedBlock block_;
  bool stopping_ = false;
  WallTime stopped_at_{};
  WallTime last_news_{};
  WallTime working_at_{};
  std::int64_t refused_ = 0;
  std::int64_t unsent_ = 0;
};

}  // namespace roadbalance

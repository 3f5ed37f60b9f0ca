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
#include "common/link/receiver.hpp"
#include "common/record/record_state.hpp"
#include "common/types/clocks.hpp"
#include "common/types/control.hpp"
#include "host/recorder/device_notes.hpp"
#include "host/recorder/epoch_counters.hpp"
#include "host/recorder/epoch_scope.hpp"
#include "host/recorder/heard_epochs.hpp"
#include "host/recorder/node_control.hpp"
#include "host/recorder/node_presence.hpp"

namespace roadbalance {

/// Everything of a node epoch through `sequence` is on the disk.
struct DurableMark {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t sequence = 0;
};

/// Losses and repairs, counted by the link and by the nodes, for the journal.
struct LinkCounters {
  std::int64_t refused = 0;
  std::int64_t rivals = 0;
  std::int64_t unsent = 0;
  std::map<NodeEpoch, NodeLosses> node;
};

struct RecorderLinkOptions {
  bool start = true;                ///< start each node that is claimed
  std::vector<std::int32_t> nodes;  ///< record only these; empty: every node heard
  std::vector<Heartbeat> heard{};   ///< of the nodes that are there; empty: they are still to be heard
  bool end_with_nodes = false;      ///< be over when each of `nodes` has ended and all of it is on the disk
  /// After a stop: how long to wait without any news for the nodes' last blocks.
  std::chrono::milliseconds patience{10'000};
  std::uint64_t seed = 1;  ///< of request numbers, which two recorders must not share
  EpochScope scope{};
  std::vector<ExpectedNode> expected{};
  std::vector<Absence> absent_before{};
  std::int64_t utc_us = 0;  ///< now, of the wall clock
};

/// The recorder's half of the bus without a bus: datagrams in; deliveries, acknowledgements and commands
/// out.  A pure state machine; time comes in with every call.
///
/// An epoch is received from when it obeys us on: until then it is another recorder's, and only observed.
/// When that recorder dies its lease is over after a second; this one then gets all that the node still
/// holds, and the two records together are the drive.
class RecorderLink {
 public:
  /// @param recovered  what the record holds: it is not taken again
  RecorderLink(RecorderLinkOptions options, std::int64_t incarnation, const RecordState& recovered);
  RecorderLink(const RecorderLink&) = delete;
  RecorderLink& operator=(const RecorderLink&) = delete;

  /// A datagram of any channel; those of other channels than heartbeat, block and reply are passed over.
  void take(std::string_view channel, std::span<const std::uint8_t> bytes, WallTime now);
  void durable(const DurableMark& mark, WallTime now);
  /// False: no new credit, because the disk fails or is full; the nodes keep what they have.
  void set_credit_open(bool open);
  /// Sends what is due: acknowledgements and commands.
  void turn(WallTime now, const Publish& publish);
  /// Deliveries for the record, since the last call.
  std::vector<Delivery> deliveries();
  /// Other notes for the record, since the last call: who is missed, and that it is to end.
  std::vector<NoteToRecord> notes() { return std::exchange(notes_, {}); }
  /// Notes of the devices of nodes that are recorded here, since the last call.
  std::vector<DeviceNote> device_notes() { return std::exchange(device_notes_, {}); }

  /// From now on nodes are stopped and their ends waited for.
  /// @param by  who stops it, for the record
  void stop(WallTime now, const std::string& by = "");
  /// Nothing more is to be waited for, and the nodes have heard that their blocks are durable, or are silent.
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
  /// The absences of nodes that should have measured.
  std::vector<Absence> absences(WallTime now, std::int64_t utc_us) const {
    return presence_.absences(now, utc_us);
  }
  LinkCounters counters() const;
  /// Fills in the link side of the status.
  void fill(RecorderStatus& status) const;
  /// Sentences for people, since the last call.
  std::vector<std::string> warnings() { return foreign_.sentences(); }

 private:
  /// Keeps the nodes that obey another recorder, and reports each once; a pure state machine.
  ///
  /// A node obeys a dead recorder until its lease is over, which is no news: it counts as another's after
  /// kPatience.
  class ForeignNodes {
   public:
    void take(const Heartbeat& heartbeat, std::int64_t our_incarnation, WallTime now);

    /// Those that obey another recorder now.
    std::vector<std::int32_t> nodes() const;
    /// For people, since the last call.
    std::vector<std::string> sentences() { return std::exchange(sentences_, {}); }

   private:
    static constexpr std::chrono::seconds kPatience{3};
    struct Node {
      WallTime since{};
      WallTime heard{};
      bool is_reported = false;
    };
    std::map<std::int32_t, Node> nodes_;
    std::vector<std::string> sentences_;
  };
  void count_silence_to(WallTime now);
  void on_heartbeat(std::span<const std::uint8_t> bytes, WallTime now);
  void hear(const Heartbeat& heartbeat, WallTime now);
  void on_block(std::span<const std::uint8_t> bytes, WallTime now);
  void note_early_end(const Heartbeat& heartbeat, WallTime now);
  void on_reply(std::span<const std::uint8_t> bytes);
  bool is_ours(const NodeEpoch& key) const;
  bool has_room_for(std::int32_t node, WallTime now);
  void set_apart(const Heartbeat& heartbeat);
  void send(const Command& command, const Publish& publish);

  const RecorderLinkOptions options_;
  std::vector<Heartbeat> heard_before_;  // and not yet looked at
  Receiver receiver_;
  NodeControl control_;
  EpochCounters counters_;
  ForeignNodes foreign_;
  HeardEpochs heard_;
  NodePresence presence_;
  std::set<std::int32_t> nodes_led_;  // kMostNodes at most
  std::int32_t left_out_ = 0;         // heard last
  WallTime left_out_at_{};
  std::set<NodeEpoch> ended_early_;  // of the rest of a recording that is fetched
  std::set<NodeEpoch> former_;       // of recordings before, whichever recorder leads them by now
  std::optional<WallTime> listening_since_;
  std::optional<WallTime> called_at_;  // last
  std::vector<Delivery> delivered_;
  std::size_t counted_ = 0;  // of delivered_
  std::vector<DeviceNote> device_notes_;
  std::vector<NoteToRecord> notes_;
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

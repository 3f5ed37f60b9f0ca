#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "common/link/epoch_receiver.hpp"

namespace roadbalance {

/// The recorder's half of the loss-free link for all nodes, as a pure state machine: time comes in with every
/// call, deliveries and acknowledgements go out; bus and disk stay outside.
///
/// A node's heartbeat opens its epoch.  Several epochs of one node may live at a time (it was started again,
/// or two nodes have one number): each is recorded apart.  An epoch without an end is closed as a crash when
/// it has been silent for ten seconds and a newer one of the node lives, or by finish().  Blocks of a closed
/// epoch are acknowledged a few times, as far as it had come without a hole.  Blocks of other epochs and
/// previews (sequence 0) never enter.
///
/// Memory: at most kMostNodes nodes, kMostLive epochs of each and kMostLiveInAll in all, each an
/// EpochReceiver; of closed ones a few bytes each, the oldest forgotten beyond 1024 a node.
class Receiver {
 public:
  enum class Refused { kPreview, kUnknownEpoch, kClosedEpoch, kDuplicate, kOutsideWindow, kCount };
  using RefusedCounts = std::array<std::int64_t, static_cast<std::size_t>(Refused::kCount)>;
  static constexpr std::size_t kMostLive = 8;
  static constexpr std::size_t kMostLiveInAll = 2 * kMostNodes;

  explicit Receiver(std::int64_t incarnation) : Receiver(incarnation, ReceiverOptions{}) {}
  Receiver(std::int64_t incarnation, ReceiverOptions options);

  /// Before anything else: what the record already holds of an epoch.  Blocks it holds are not taken again.
  void recover(std::int32_t node, std::int64_t epoch, EpochPosition position);

  void take(const SealedBlock& block, WallTime now, std::vector<Delivery>& out);
  void take(const Heartbeat& heartbeat, WallTime now, std::vector<Delivery>& out);
  /// Everything of the epoch through `sequence` is on the disk: the next due() acknowledges it.
  void durable(std::int32_t node, std::int64_t epoch, std::int64_t sequence);
  /// False: no credit beyond what was given, because the disk fails or is full.  Open at first.
  void set_credit_open(bool open);
  /// The recorder ends: closes as crashed each epoch that has no end and has been silent for ten seconds, or
  /// for one if a newer epoch of the node was received.  An epoch that only sleeps stays open for the next
  /// recorder.
  /// @param leaves_open  an epoch that has been silent for long stays open, too, unless a newer one of the
  ///                     node was received
  void finish(WallTime now, bool leaves_open, std::vector<Delivery>& out);
  void finish(WallTime now, std::vector<Delivery>& out) { finish(now, false, out); }
  /// Nothing more comes of this epoch: it is closed as crashed if it is known and has no end.
  void give_up(std::int32_t node, std::int64_t epoch, std::vector<Delivery>& out);

  /// The caller was held (a debugger, a swap, SIGSTOP) for so long and received nothing: that silence is not
  /// the nodes'.
  void was_held(std::chrono::nanoseconds duration);

  /// Acknowledgements to send now: five times a second, at once when more is durable and before the credit
  /// runs out, 25 times a second while a living node has not got the latest durable position or nothing more
  /// comes of what it has, and up to 200 times while there are blocks to ask for.
  std::vector<Ack> due(WallTime now);

  /// The epoch if it is being received or was closed a moment ago, else nullptr.
  const EpochReceiver* find(std::int32_t node, std::int64_t epoch) const;
  std::int64_t incarnation() const { return incarnation_; }
  /// For a restart of the same recorder with a higher number: ack numbers begin again.
  void set_incarnation(std::int64_t incarnation) { incarnation_ = incarnation; }
  /// Nodes that have been received.
  std::size_t nodes() const { return nodes_.size(); }
  const RefusedCounts& refused() const { return refused_; }
  /// Heartbeats of an epoch between which another one of the node was received, and of epochs that were
  /// closed and still hold blocks: two nodes have one number, or a node that slept is awake again.
  std::int64_t rival_heartbeats() const { return rival_heartbeats_; }

 private:
  struct Live {
    std::unique_ptr<EpochReceiver> receiver;
    WallTime heard_at{};
    WallTime acked_at{};
    std::int64_t acked_durable = -1;
    std::int64_t acked_received = 0;
    std::int64_t base = 1;  // the oldest block it holds, by its heartbeats, ...
    std::int64_t next = 1;  // ... and the next it will seal
    int last_acks;          // left, once it is closed
  };
  struct Past {
    std::int64_t epoch;
    EpochPosition position;
    std::optional<WallTime> superseded_at{};  // open still: when another epoch of the node was first received
  };
  struct Node {
    std::vector<Live> live;  // in order of opening
    std::vector<Past> past;  // recovered or over, in order of time
    std::int64_t ack_number = 0;
  };
  static Live* find_live(Node& node, std::int64_t epoch);
  static Past* find_past(Node& node, std::int64_t epoch);
  Live& open(Node& node, std::int32_t number, std::int64_t epoch, const EpochPosition& start);
  bool may_open(Node& node, const Heartbeat& heartbeat, WallTime now, std::vector<Delivery>& out);
  bool make_room(Node& node, WallTime now, std::vector<Delivery>& out);
  std::size_t live_in_all() const;
  void note_rivals(const Node& node, const Live& live);
  void close_silent(Node& node, std::int32_t number, std::int64_t epoch, WallTime now,
                    std::vector<Delivery>& out);
  void close_past(Node& node, std::int32_t number, Past& past, std::vector<Delivery>& out);
  void retire(Node& node, std::size_t which);
  bool is_due(const Live& live, WallTime now) const;
  void acknowledge(Node& node, Live& live, WallTime now, std::vector<Ack>& acks) const;

  std::int64_t incarnation_;
  const ReceiverOptions options_;
  bool credit_open_ = true;
  std::map<std::int32_t, Node> nodes_;
  std::optional<WallTime> began_at_;
  RefusedCounts refused_{};
  std::int64_t rival_heartbeats_ = 0;
};

}  // namespace roadbalance

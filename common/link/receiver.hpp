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
/// A node's heartbeat opens its epoch; a heartbeat with a new epoch closes the old one, as a crash if it has
/// no end; what it left is acknowledged a few times once durable.  Blocks of other epochs and previews
/// (sequence 0) never enter.
class Receiver {
 public:
  enum class Refused { kPreview, kUnknownEpoch, kClosedEpoch, kDuplicate, kOutsideWindow, kCount };
  using RefusedCounts = std::array<std::int64_t, static_cast<std::size_t>(Refused::kCount)>;

  explicit Receiver(std::int64_t incarnation) : Receiver(incarnation, ReceiverOptions{}) {}
  Receiver(std::int64_t incarnation, ReceiverOptions options);

  /// Before anything else: what the record already holds of an epoch.  Blocks it holds are not taken again.
  void recover(std::int32_t node, std::int64_t epoch, EpochPosition position);

  void take(const SealedBlock& block, WallTime now, std::vector<Delivery>& out);
  void take(const Heartbeat& heartbeat, WallTime now, std::vector<Delivery>& out);
  /// Everything of the epoch through `sequence` is on the disk: the next due() acknowledges it.
  void durable(std::int32_t node, std::int64_t epoch, std::int64_t sequence);

  /// Acknowledgements to send now: five times a second, twenty times while there are holes, at once when more
  /// is durable, and before the credit runs out.
  std::vector<Ack> due(WallTime now);

  /// The epoch being received of a node, or nullptr.
  const EpochReceiver* current(std::int32_t node) const;
  std::int64_t incarnation() const { return incarnation_; }
  /// For a restart of the same recorder with a higher number: ack numbers begin again.
  void set_incarnation(std::int64_t incarnation) { incarnation_ = incarnation; }
  const RefusedCounts& refused() const { return refused_; }
  /// Heartbeats of a second epoch while the first one lived: two nodes with one number, or late datagrams.
  std::int64_t rival_heartbeats() const { return rival_heartbeats_; }

 private:
  struct Past {
    std::int64_t epoch;
    EpochPosition position;
    std::int64_t durable = 0;
    int acks_left = 0;  // to say that all of it is durable
    WallTime acked_at{};
  };
  struct Node {
    std::unique_ptr<EpochReceiver> epoch;  // being received
    std::vector<Past> past;                // recovered or closed, in order of time
    WallTime heard_at{};                   // the epoch being received
    std::int64_t ack_number = 0;
    WallTime acked_at{};
    std::int64_t acked_durable = -1;
    std::int64_t acked_received = 0;
  };
  bool is_due(const Node& node, WallTime now) const;
  static Past* find_past(Node& node, std::int64_t epoch);
  static void close(Past& past, const EpochReceiver& epoch);
  void acknowledge_past(std::int32_t number, Node& node, WallTime now, std::vector<Ack>& acks) const;
  bool may_open(Node& node, const Heartbeat& heartbeat, WallTime now);
  void open_epoch(Node& node, const Heartbeat& heartbeat, std::vector<Delivery>& out);

  std::int64_t incarnation_;
  const ReceiverOptions options_;
  std::map<std::int32_t, Node> nodes_;
  RefusedCounts refused_{};
  std::int64_t rival_heartbeats_ = 0;
};

}  // namespace roadbalance

#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "common/bus/control_messages.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// Claims the node epochs heard, starts them, and stops and releases them in the end; a pure state machine.
/// Two epochs of one node are led apart: a command names the one that it is for.
///
/// All that are there begin at one instant, which each start names, and end at another: a command is
/// repeated until that is over, for one may be lost or late.  A node that comes later begins as soon as it
/// can have heard of it.
///
/// A command is repeated with the same request number until it is answered or the heartbeat shows its effect;
/// after a refusal it is asked anew.  An epoch that is silent is sent nothing.  Beyond kMostEpochs, the epoch
/// silent for longest is forgotten.
class NodeControl {
 public:
  /// @param start          each node epoch in preview, or leave it there
  /// @param ends_previews  stop those in preview, too: they will never be started
  /// @param notice         from when the first node is heard to their common start
  NodeControl(std::int64_t incarnation, bool start, std::uint64_t seed, bool ends_previews = false,
              std::chrono::milliseconds notice = notice_for(1));

  /// For so many nodes to hear of an instant, also where datagrams are lost and processors are busy.
  static std::chrono::milliseconds notice_for(std::size_t nodes);

  void take(const Heartbeat& heartbeat);
  void take(const Reply& reply);
  /// From now on nodes are stopped.
  void stop() { stopping_ = true; }
  void set_incarnation(std::int64_t incarnation);

  /// Commands to send now.
  std::vector<Command> due(WallTime now);
  /// Release commands for all nodes owned, for the end.
  std::vector<Command> farewell();

  /// The highest incarnation above our own that a node obeys or has obeyed: an earlier recorder whose clock
  /// was ahead. 0: none.
  std::int64_t obeyed_higher() const { return obeyed_higher_; }
  /// The epoch was started, or may be about to start, and has obeyed us: its end is to be waited for.  One
  /// that only ever obeyed another recorder is that one's to end.
  bool was_started(std::int32_t node, std::int64_t epoch) const;
  /// It has been heard to obey us at some time.
  bool has_obeyed(std::int32_t node, std::int64_t epoch) const;
  /// A node that has been started is asked to obey, has not been heard to do so yet and is not silent: what
  /// it holds is not known.
  bool is_asking(WallTime now) const;
  /// It obeys us now, as far as is known.
  bool is_owned(std::int32_t node, std::int64_t epoch) const;

  static constexpr std::size_t kMostEpochs = 2 * kMostNodes;

 private:
  using Key = std::pair<std::int32_t, std::int64_t>;
  struct Node {
    NodeState state = NodeState::kPreview;
    bool owned = false;
    bool obeyed = false;    // was owned at some time
    bool heard_so = false;  // by a heartbeat, which has what it holds, not only by an answer
    bool is_start_answered = false;
    std::optional<WallTime> start_at{};
    bool started = false;  // measures or has measured, a start is under way to it, or it is to end unstarted
    Verb verb = Verb::kRelease;  // of the request below; release: none
    std::int64_t request = 0;
    WallTime sent_at{};
    std::int64_t heard = 0;  // number of its last heartbeat among all
    std::int64_t seen = 0;   // the same, when due() looked last ...
    WallTime heard_at{};     // ... and then
    bool is_ours_to_end() const { return started && obeyed; }
  };
  void note_obeyed(std::int64_t incarnation);
  Verb wanted(const Node& node, WallTime now) const;
  bool announces(const Node& node, WallTime now) const;
  std::chrono::milliseconds repeats_after(const Node& node, Verb verb, WallTime now) const;
  void appoint(WallTime now);
  bool is_silent(Node& node, WallTime now) const;
  std::int64_t new_request();
  Command command(const Key& key, const Node& node, WallTime now) const;

  std::int64_t incarnation_;
  const bool start_;
  const bool ends_previews_;
  const std::chrono::milliseconds notice_;
  std::chrono::milliseconds stop_notice_{};
  std::optional<WallTime> start_at_, stop_at_;  // of all
  bool stopping_ = false;
  std::int64_t obeyed_higher_ = 0;
  std::mt19937_64 random_;
  std::int64_t heartbeats_ = 0;
  std::map<Key, Node> nodes_;
};

}  // namespace roadbalance

#include "host/recorder/control/pending_epochs.hpp"

#include <algorithm>
#include <utility>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kHeard{1000};
constexpr milliseconds kLongSilence{10'000};
constexpr milliseconds kAgain{5000};
constexpr milliseconds kCacheLife{1000};
constexpr std::size_t kMostHeard = 4 * kMostNodes;  // whatever the bus brings

bool holds_something(const NodeReport& epoch) {
  // Its end may be on the disk, and it has not heard so: it keeps its last blocks until then.
  if (epoch.ended) return epoch.holds_blocks;
  return epoch.blocks > 0 || epoch.samples_sent > 0 || epoch.started;
}

// Nothing was heard of the node since a recorder before wrote the epoch's end.
bool may_hold_its_end(const NodeReport& earlier, const std::vector<NodeReport>& heard) {
  return earlier.ended && !earlier.crashed &&
         std::ranges::find(heard, earlier.node, &NodeReport::node) == heard.end();
}

const NodeReport* find(const std::vector<NodeReport>& epochs, const NodeEpoch& key) {
  const auto found = std::ranges::find_if(epochs, [&](const NodeReport& epoch) {
    return NodeEpoch{epoch.node, epoch.epoch} == key;
  });
  return found == epochs.end() ? nullptr : &*found;
}

}  // namespace

std::vector<PendingEpoch> pending_of(const RecorderReport& report, const std::string& recording) {
  std::vector<PendingEpoch> pending;
  const auto owe = [&](const NodeReport& epoch) {
    pending.push_back({.recording = recording, .node = epoch.node, .epoch = epoch.epoch});
  };
  for (const NodeReport& epoch : report.earlier)
    if (holds_something(epoch) || may_hold_its_end(epoch, report.node)) owe(epoch);
  for (const NodeReport& epoch : report.node)
    if (holds_something(epoch)) owe(epoch);
  return pending;
}

void PendingEpochs::take(const Heartbeat& heartbeat, WallTime now) {
  std::erase_if(heard_, [now](const auto& one) { return now - one.second.last >= kLongSilence; });
  const NodeEpoch key{heartbeat.node, heartbeat.epoch};
  if (heard_.size() >= kMostHeard && !heard_.contains(key)) return;
  Heard& heard = heard_.try_emplace(key, Heard{.first = now, .owned_since = now}).first->second;
  heard.last = now;
  if (std::exchange(heard.owner, heartbeat.owner) != heartbeat.owner) heard.owned_since = now;
  heard.holds_samples = roadbalance::holds_samples(heartbeat);
}

std::vector<PendingEpoch> PendingEpochs::unknown(const std::vector<PastRecording>& past,
                                                 const std::vector<PendingEpoch>& pending, WallTime now) {
  std::vector<PendingEpoch> unknown;
  for (const auto& entry : heard_) {
    const auto& key = entry.first;  // clang 14 takes no structured binding into a lambda
    const auto& heard = entry.second;
    if (!heard.holds_samples || heard.is_settled) continue;
    // A heartbeat may be late: one of a node that has ended meanwhile.
    if (heard.last - heard.first < kHeard || now - heard.last > kHeard) continue;
    const auto of = std::ranges::find_if(past.rbegin(), past.rend(), [&](const PastRecording& one) {
      // Another recorder may have begun between two of that recording.
      return one.first_incarnation <= heard.owner && heard.owner <= one.last_incarnation &&
             is_of(one.recording, heard.owner, now);
    });
    const auto is_it = [&](const PendingEpoch& epoch) { return NodeEpoch{epoch.node, epoch.epoch} == key; };
    if (of != past.rend() && std::ranges::none_of(pending, is_it))
      unknown.push_back({.recording = of->recording, .node = key.first, .epoch = key.second});
  }
  return unknown;
}

std::vector<PendingEpoch> PendingEpochs::taken_over(const std::vector<PendingEpoch>& pending, WallTime now) {
  std::vector<PendingEpoch> taken;
  for (const PendingEpoch& epoch : pending)
    if (const Heard* const heard = heard_now(epoch, now);
        heard && heard->last - heard->owned_since >= kPatience && !is_free(epoch, now))
      taken.push_back(epoch);
  return taken;
}

const PendingEpochs::Heard* PendingEpochs::heard_now(const PendingEpoch& epoch, WallTime now) const {
  const auto heard = heard_.find({epoch.node, epoch.epoch});
  return heard != heard_.end() && now - heard->second.last <= kHeard ? &heard->second : nullptr;
}

bool PendingEpochs::is_of(const std::string& recording, std::int64_t incarnation, WallTime now) {
  std::erase_if(is_of_cache_, [now](const auto& one) { return now - one.second.at >= kCacheLife; });
  const auto [cached, is_new] = is_of_cache_.try_emplace({recording, incarnation}, CachedResult{.at = now});
  if (is_new) cached->second.is_of = is_of_(recording, incarnation);
  return cached->second.is_of;
}

// It is heard, and obeys no recorder or this recording.
bool PendingEpochs::is_free(const PendingEpoch& epoch, WallTime now) {
  const Heard* const heard = heard_now(epoch, now);
  return heard && (heard->owner == 0 || is_of(epoch.recording, heard->owner, now));
}

bool PendingEpochs::is_lost(const PendingEpoch& epoch, WallTime now) const {
  const auto own = heard_.find({epoch.node, epoch.epoch});
  if (own != heard_.end() && now - own->second.last < kLongSilence) return false;
  return std::ranges::any_of(heard_, [&](const auto& other) {
    const auto& [key, heard] = other;
    return key.first == epoch.node && key.second != epoch.epoch && now - heard.last <= kHeard &&
           heard.last - heard.first >= kLongSilence;
  });
}

std::optional<PendingEpochs::Outcome> PendingEpochs::turn(const std::vector<PendingEpoch>& pending,
                                                          WallTime now) {
  if (!session_) begin_one(pending, now);
  if (!session_) return std::nullopt;
  const Session::View view = session_->view();
  if (!view.is_over) {
    if (!is_taken_from_session(now)) return std::nullopt;
    tried_at_[recording_] = now;
    leave();
    return std::nullopt;
  }
  Outcome outcome = end(view.report, view.error);
  for (const PendingEpoch& epoch : outcome.settled)
    if (const auto heard = heard_.find({epoch.node, epoch.epoch}); heard != heard_.end())
      heard->second.is_settled = true;
  leave();
  tried_at_[outcome.recording] = now;
  return outcome;
}

// It would go on claiming what another recorder leads meanwhile.
bool PendingEpochs::is_taken_from_session(WallTime now) {
  return std::ranges::any_of(scope_.only, [&](const NodeEpoch& key) {
    const PendingEpoch epoch{.recording = recording_, .node = key.first, .epoch = key.second};
    return heard_now(epoch, now) && !is_free(epoch, now);
  });
}

void PendingEpochs::leave() {
  session_.reset();
  recording_.clear();
}

// Takes the recording that was tried longest ago, of those that have something to be done.
void PendingEpochs::begin_one(const std::vector<PendingEpoch>& pending, WallTime now) {
  std::erase_if(tried_at_, [&](const auto& tried) {
    return std::ranges::none_of(pending,
                                [&](const PendingEpoch& epoch) { return epoch.recording == tried.first; });
  });
  std::map<std::string, EpochScope> to_do;
  for (const PendingEpoch& epoch : pending) {
    const bool lost = is_lost(epoch, now);
    if (!lost && !is_free(epoch, now)) continue;
    EpochScope& scope = to_do[epoch.recording];
    scope.only.emplace_back(epoch.node, epoch.epoch);
    if (lost) scope.given_up.emplace_back(epoch.node, epoch.epoch);
  }
  const auto tried_at = [this](const std::string& recording) {
    const auto tried = tried_at_.find(recording);
    return tried == tried_at_.end() ? WallTime::min() : tried->second;
  };
  std::erase_if(to_do, [&](const auto& one) {
    return tried_at(one.first) != WallTime::min() && now - tried_at(one.first) < kAgain;
  });
  if (to_do.empty()) return;
  const auto next = std::ranges::min_element(to_do, {}, [&](const auto& one) { return tried_at(one.first); });
  recording_ = next->first;
  scope_ = next->second;
  scope_.leaves_open = true;
  session_ = begin_(recording_, scope_);
  session_->stop("");
}

PendingEpochs::Outcome PendingEpochs::end(const RecorderReport& report, const std::string& error) const {
  Outcome outcome{.recording = recording_, .settled = {}, .lost = {}, .report = report, .error = error};
  if (!error.empty()) return outcome;
  for (const auto& key : scope_.only) {
    const PendingEpoch epoch{.recording = recording_, .node = key.first, .epoch = key.second};
    const NodeReport* const heard = find(report.node, key);
    const NodeReport* const known = heard ? heard : find(report.earlier, key);
    // That its end is on the disk is not enough: a node that was not heard may not have heard so.
    const bool has_let_go = heard && !holds_something(*heard);
    const bool crashed = known && known->crashed;  // nothing of it is taken any more
    const bool given_up = std::ranges::find(scope_.given_up, key) != scope_.given_up.end();
    if (has_let_go || crashed || given_up) outcome.settled.push_back(epoch);
    if (given_up && !(known && known->ended && !crashed)) outcome.lost.push_back(epoch);
  }
  return outcome;
}

}  // namespace roadbalance

#include "host/recorder/rest_fetching.hpp"

#include <algorithm>
#include <utility>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kHeard{1000};
constexpr milliseconds kLongSilence{10'000};
constexpr milliseconds kAgain{5000};
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

std::vector<Rest> rests_of(const RecorderReport& report, const std::string& recording) {
  std::vector<Rest> rests;
  const auto owe = [&](const NodeReport& epoch) {
    rests.push_back({.recording = recording, .node = epoch.node, .epoch = epoch.epoch});
  };
  for (const NodeReport& epoch : report.earlier)
    if (holds_something(epoch) || may_hold_its_end(epoch, report.node)) owe(epoch);
  for (const NodeReport& epoch : report.node)
    if (holds_something(epoch)) owe(epoch);
  return rests;
}

void RestFetching::take(const Heartbeat& heartbeat, WallTime now) {
  std::erase_if(heard_, [now](const auto& one) { return now - one.second.last >= kLongSilence; });
  const NodeEpoch key{heartbeat.node, heartbeat.epoch};
  if (heard_.size() >= kMostHeard && !heard_.contains(key)) return;
  Heard& heard = heard_.try_emplace(key, Heard{.first = now}).first->second;
  heard.last = now;
  heard.owner = heartbeat.owner;
  heard.holds_samples = roadbalance::holds_samples(heartbeat);
}

std::vector<Rest> RestFetching::unknown(const std::vector<Over>& over, const std::vector<Rest>& rests,
                                        WallTime now) const {
  std::vector<Rest> unknown;
  for (const auto& entry : heard_) {
    const auto& key = entry.first;  // clang 14 takes no structured binding into a lambda
    const auto& heard = entry.second;
    if (!heard.holds_samples || heard.is_settled) continue;
    // A heartbeat may be late: one of a node that has ended meanwhile.
    if (heard.last - heard.first < kHeard || now - heard.last > kHeard) continue;
    const auto of = std::ranges::find_if(over.rbegin(), over.rend(), [&](const Over& one) {
      return one.first_incarnation <= heard.owner && heard.owner <= one.last_incarnation;
    });
    const auto is_it = [&](const Rest& rest) { return NodeEpoch{rest.node, rest.epoch} == key; };
    if (of != over.rend() && std::ranges::none_of(rests, is_it))
      unknown.push_back({.recording = of->recording, .node = key.first, .epoch = key.second});
  }
  return unknown;
}

bool RestFetching::is_heard(const Rest& rest, WallTime now) const {
  const auto heard = heard_.find({rest.node, rest.epoch});
  return heard != heard_.end() && now - heard->second.last <= kHeard;
}

bool RestFetching::is_lost(const Rest& rest, WallTime now) const {
  const auto own = heard_.find({rest.node, rest.epoch});
  if (own != heard_.end() && now - own->second.last < kLongSilence) return false;
  return std::ranges::any_of(heard_, [&](const auto& other) {
    const auto& [key, heard] = other;
    return key.first == rest.node && key.second != rest.epoch && now - heard.last <= kHeard &&
           heard.last - heard.first >= kLongSilence;
  });
}

std::optional<RestFetching::Outcome> RestFetching::turn(const std::vector<Rest>& rests, WallTime now) {
  if (!session_) begin_one(rests, now);
  if (!session_) return std::nullopt;
  const Session::View view = session_->view();
  if (!view.is_over) return std::nullopt;
  Outcome outcome = end(view.report, view.error);
  for (const Rest& rest : outcome.settled)
    if (const auto heard = heard_.find({rest.node, rest.epoch}); heard != heard_.end())
      heard->second.is_settled = true;
  leave();
  tried_at_[outcome.recording] = now;
  return outcome;
}

void RestFetching::leave() {
  session_.reset();
  recording_.clear();
}

// Of the recordings that have something to be done the one that was tried longest ago.
void RestFetching::begin_one(const std::vector<Rest>& rests, WallTime now) {
  std::erase_if(tried_at_, [&](const auto& tried) {
    return std::ranges::none_of(rests, [&](const Rest& rest) { return rest.recording == tried.first; });
  });
  std::map<std::string, EpochScope> to_do;
  for (const Rest& rest : rests) {
    const bool lost = is_lost(rest, now);
    if (!lost && !is_heard(rest, now)) continue;
    EpochScope& scope = to_do[rest.recording];
    scope.only.emplace_back(rest.node, rest.epoch);
    if (lost) scope.given_up.emplace_back(rest.node, rest.epoch);
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
  session_->stop();
}

RestFetching::Outcome RestFetching::end(const RecorderReport& report, const std::string& error) const {
  Outcome outcome{.recording = recording_, .settled = {}, .lost = {}, .report = report, .error = error};
  if (!error.empty()) return outcome;
  for (const auto& key : scope_.only) {
    const Rest rest{.recording = recording_, .node = key.first, .epoch = key.second};
    const NodeReport* const heard = find(report.node, key);
    const NodeReport* const known = heard ? heard : find(report.earlier, key);
    // That its end is on the disk is not enough: a node that was not heard may not know so.
    const bool has_let_go = heard && !holds_something(*heard);
    const bool crashed = known && known->crashed;  // nothing of it is taken any more
    const bool given_up = std::ranges::find(scope_.given_up, key) != scope_.given_up.end();
    if (has_let_go || crashed || given_up) outcome.settled.push_back(rest);
    if (given_up && !(known && known->ended && !crashed)) outcome.lost.push_back(rest);
  }
  return outcome;
}

}  // namespace roadbalance

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
  return !epoch.ended && (epoch.blocks > 0 || epoch.samples_sent > 0 || epoch.started);
}

}  // namespace

std::vector<Rest> rests_of(const RecorderReport& report, const std::string& recording) {
  std::vector<Rest> rests;
  for (const auto* epochs : {&report.earlier, &report.node})
    for (const NodeReport& epoch : *epochs)
      if (holds_something(epoch))
        rests.push_back({.recording = recording, .node = epoch.node, .epoch = epoch.epoch});
  return rests;
}

void RestFetching::take(const Heartbeat& heartbeat, WallTime now) {
  std::erase_if(heard_, [now](const auto& one) { return now - one.second.last >= kLongSilence; });
  const NodeEpoch key{heartbeat.node, heartbeat.epoch};
  if (heard_.size() >= kMostHeard && !heard_.contains(key)) return;
  Heard& heard = heard_.try_emplace(key, Heard{.first = now}).first->second;
  heard.last = now;
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
    const auto is_it = [&](const NodeReport& epoch) { return NodeEpoch{epoch.node, epoch.epoch} == key; };
    const auto heard = std::ranges::find_if(report.node, is_it);
    const auto before = std::ranges::find_if(report.earlier, is_it);
    const bool is_empty = heard != report.node.end() && !holds_something(*heard);
    const bool ended = before != report.earlier.end() && before->ended;
    const bool given_up = std::ranges::find(scope_.given_up, key) != scope_.given_up.end();
    if (ended || is_empty || given_up || (heard != report.node.end() && heard->ended))
      outcome.settled.push_back(rest);
    // By then the declared crash is its end, too.
    if (given_up && !(ended && before->sums_agree)) outcome.lost.push_back(rest);
  }
  return outcome;
}

}  // namespace roadbalance

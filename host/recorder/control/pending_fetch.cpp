#include "host/recorder/control/pending_fetch.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "common/record/folder.hpp"
#include "host/recorder/control/node_receipts.hpp"
#include "host/recorder/incarnation.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kLastHeartbeats{2000};

std::string nodes_of(const std::vector<PendingEpoch>& pending) {
  std::string nodes;
  for (const PendingEpoch& one : pending)
    nodes += (nodes.empty() ? "node " : ", ") + std::to_string(one.node);
  return nodes;
}

std::vector<Receipt> unchanged(const std::vector<Receipt>& before) {
  return before;
}

}  // namespace

PendingFetch::PendingFetch(const OperateOptions& options, Disk& disk, BeginSession begin,
                           RecordingsFolder& folder, RecordingsFolder::Warn warn, WallTime now)
    : options_(options),
      disk_(disk),
      begin_(std::move(begin)),
      folder_(folder),
      warn_(std::move(warn)),
      pending_(
          [this](const std::string& name, EpochScope scope) { return begin_session(name, std::move(scope)); },
          [this](const std::string& name, std::int64_t incarnation) { return has_had(name, incarnation); }),
      ended_at_(now) {}

// Beside whatever else is recorded, with an incarnation of its own.
std::unique_ptr<Session> PendingFetch::begin_session(const std::string& recording, EpochScope scope) const {
  RecorderOptions options = options_.recorder;
  options.folder = options_.recordings / recording;
  if (!options.fallback.empty()) options.fallback /= recording;
  options.continues = true;
  options.start = false;
  options.sends_state = options.keeps_awake = false;
  options.power.clear();  // a line has one reader, and the recording under way may be it
  options.scope = std::move(scope);
  return begin_(std::move(options));
}

std::optional<RecorderReport> PendingFetch::turn(SessionController& controller, WallTime now) {
  add_unknown(controller, now);
  if (controller.pending().empty()) return std::nullopt;
  if (pending_.under_way().empty()) {
    forget_without_folder(controller);
    leave_to_others(controller, now);
  }
  const auto outcome = pending_.turn(controller.pending(), now);
  if (!outcome) return std::nullopt;
  const std::string name = "\"" + outcome->recording + "\"";
  if (!outcome->error.empty()) {
    warn_("the rest of " + name + " stays at its node for now: " + outcome->error);
    return std::nullopt;
  }
  const std::int64_t bytes = bytes_of_folder(options_.recordings / outcome->recording, disk_);
  controller.settled(outcome->settled, [&](const std::vector<Receipt>& before) {
    return completed(before, outcome->report, bytes);
  });
  if (!outcome->lost.empty())
    warn_(nodes_of(outcome->lost) + " was started anew: what it held of " + name +
          " is lost, and the recording says so");
  else if (!outcome->settled.empty())
    warn_("the rest of " + name + " is on the disk (" + nodes_of(outcome->settled) + ")");
  return outcome->report;
}

// In the folder or in its fallback; as far as they can be read.
std::vector<std::int64_t> PendingFetch::incarnations_of(const std::string& recording) const {
  std::vector<std::int64_t> all;
  for (const auto& place : {options_.recordings, options_.recorder.fallback}) {
    if (place.empty()) continue;
    try {
      const auto numbers = stored_incarnations(place / recording, disk_);
      all.insert(all.end(), numbers.begin(), numbers.end());
    } catch (const std::exception&) {
    }
  }
  return all;
}

// Where no number can be read, the session that is to fetch reports the reason.
bool PendingFetch::has_had(const std::string& recording, std::int64_t incarnation) const {
  const auto numbers = incarnations_of(recording);
  return numbers.empty() || std::ranges::find(numbers, incarnation) != numbers.end();
}

std::vector<IncarnationRange> PendingFetch::former_incarnations(
    const std::vector<PastRecording>& past) const {
  std::vector<IncarnationRange> former;
  for (const auto& [recording, first, last] : past) {
    const auto numbers = incarnations_of(recording);
    if (numbers.empty()) former.push_back({first, last});
    for (const std::int64_t number : numbers)
      if (first <= number && number <= last) former.push_back({number, number});
  }
  return former;
}

// Those of recordings that a person has moved away: data that a node holds of them has no place any more.  A
// disk that fails or is not mounted shows nothing of what is there.
std::vector<PendingEpoch> PendingFetch::without_folder(const std::vector<PendingEpoch>& pending) {
  std::vector<PendingEpoch> gone;
  try {
    if (!pending.empty()) folder_.require_its_disk();
    for (const PendingEpoch& one : pending)
      if (!path_exists(options_.recordings / one.recording, disk_)) gone.push_back(one);
  } catch (const std::exception&) {
    return {};
  }
  return gone;
}

void PendingFetch::add_unknown(SessionController& controller, WallTime now) {
  if (now - ended_at_ < kLastHeartbeats) return;
  std::vector<PendingEpoch> unknown = pending_.unknown(controller.past(), controller.pending(), now);
  for (const PendingEpoch& gone : without_folder(unknown)) std::erase(unknown, gone);
  controller.owe(unknown);
}

// Nothing of these is to be fetched any more, and the next recording takes their nodes as it takes others
// that obey another recorder: when that one is silent or lets them go.
void PendingFetch::leave_to_others(SessionController& controller, WallTime now) {
  const std::vector<PendingEpoch> taken = pending_.taken_over(controller.pending(), now);
  for (const PendingEpoch& one : taken) {
    warn_("node " + std::to_string(one.node) + " obeys another recorder: the rest of \"" + one.recording +
          "\" is left to that one");
    controller.settled({one}, unchanged);
  }
}

void PendingFetch::forget_without_folder(SessionController& controller) {
  std::vector<PendingEpoch> gone = without_folder(controller.pending());
  if (gone.empty()) return;
  std::erase_if(gone,
                [name = gone.front().recording](const PendingEpoch& one) { return one.recording != name; });
  warn_("\"" + gone.front().recording + "\" is not there any more: its rest at " + nodes_of(gone) +
        " is not fetched");
  controller.settled(gone, unchanged);
}

}  // namespace roadbalance

#include <algorithm>
#include <exception>

#include "common/record/folder.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recorder/operating.hpp"
#include "host/recorder/receipts.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kLastHeartbeats{2000};

std::string nodes_of(const std::vector<Rest>& rests) {
  std::string nodes;
  for (const Rest& rest : rests) nodes += (nodes.empty() ? "node " : ", ") + std::to_string(rest.node);
  return nodes;
}

}  // namespace

// Beside whatever else is recorded, with an incarnation of its own.
std::unique_ptr<Session> Operating::begin_rest(const std::string& recording, EpochScope scope) {
  RecorderOptions options = options_.recorder;
  options.folder = options_.recordings / recording;
  if (!options.fallback.empty()) options.fallback /= recording;
  options.continues = true;
  options.start = false;
  options.says_state = false;
  options.power.clear();  // a line has one reader, and the recording under way may be it
  options.scope = std::move(scope);
  return world_.begin(std::move(options));
}

void Operating::look_after_rests() {
  owe_unknown_rests();
  if (desk_.rests().empty()) return;
  if (rests_.under_way().empty()) {
    forget_rests_without_folder();
    leave_rests_to_others();
  }
  const auto outcome = rests_.turn(desk_.rests(), time_.now);
  if (!outcome) return;
  const std::string name = "\"" + outcome->recording + "\"";
  if (!outcome->error.empty())
    return warn("the rest of " + name + " stays at its node for now: " + outcome->error);
  add_to_report(outcome->report);
  const std::int64_t bytes = bytes_of_folder(options_.recordings / outcome->recording, world_.disk);
  desk_.settled(outcome->settled, [&](const std::vector<Receipt>& before) {
    return completed(before, outcome->report, bytes);
  });
  if (!outcome->lost.empty())
    warn(nodes_of(outcome->lost) + " was started anew: what it held of " + name +
         " is lost, and the recording says so");
  else if (!outcome->settled.empty())
    warn("the rest of " + name + " is on the disk (" + nodes_of(outcome->settled) + ")");
}

// In the folder or in its fallback; as far as they can be read.
std::vector<std::int64_t> Operating::incarnations_of(const std::string& recording) const {
  std::vector<std::int64_t> all;
  for (const auto& place : {options_.recordings, options_.recorder.fallback}) {
    if (place.empty()) continue;
    try {
      const auto numbers = stored_incarnations(place / recording, world_.disk);
      all.insert(all.end(), numbers.begin(), numbers.end());
    } catch (const std::exception&) {
    }
  }
  return all;
}

// Where no number can be read, the session that is to fetch says why.
bool Operating::has_had(const std::string& recording, std::int64_t incarnation) const {
  const auto numbers = incarnations_of(recording);
  return numbers.empty() || std::ranges::find(numbers, incarnation) != numbers.end();
}

std::vector<IncarnationRange> Operating::former_incarnations() const {
  std::vector<IncarnationRange> former;
  for (const auto& [recording, first, last] : desk_.over()) {
    const auto numbers = incarnations_of(recording);
    if (numbers.empty()) former.push_back({first, last});
    for (const std::int64_t number : numbers)
      if (first <= number && number <= last) former.push_back({number, number});
  }
  return former;
}

// Those of recordings that somebody has moved away: what a node holds of them has no place any more.  A disk
// that fails or is not mounted says nothing of what is there.
std::vector<Rest> Operating::without_folder(const std::vector<Rest>& rests) {
  std::vector<Rest> gone;
  try {
    if (!rests.empty()) require_its_folder();
    for (const Rest& rest : rests)
      if (!path_exists(options_.recordings / rest.recording, world_.disk)) gone.push_back(rest);
  } catch (const std::exception&) {
    return {};
  }
  return gone;
}

void Operating::owe_unknown_rests() {
  if (time_.now - ended_at_ < kLastHeartbeats) return;
  std::vector<Rest> unknown = rests_.unknown(desk_.over(), desk_.rests(), time_.now);
  for (const Rest& gone : without_folder(unknown)) std::erase(unknown, gone);
  desk_.owe(unknown);
}

// Nothing of these is to be fetched any more, and the next recording takes their nodes as it takes others
// that obey another recorder: when that one is silent or lets them go.
void Operating::leave_rests_to_others() {
  const std::vector<Rest> taken = rests_.taken_over(desk_.rests(), time_.now);
  for (const Rest& rest : taken) {
    warn("node " + std::to_string(rest.node) + " obeys another recorder: the rest of \"" + rest.recording +
         "\" is left to that one");
    desk_.settled({rest}, [](const std::vector<Receipt>& before) { return before; });
  }
}

void Operating::forget_rests_without_folder() {
  std::vector<Rest> gone = without_folder(desk_.rests());
  if (gone.empty()) return;
  std::erase_if(gone, [name = gone.front().recording](const Rest& rest) { return rest.recording != name; });
  warn("\"" + gone.front().recording + "\" is not there any more: its rest at " + nodes_of(gone) +
       " is not fetched");
  desk_.settled(gone, [](const std::vector<Receipt>& before) { return before; });
}

}  // namespace roadbalance

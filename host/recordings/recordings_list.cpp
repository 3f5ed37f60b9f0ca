#include "host/recordings/recordings_list.hpp"

#include <algorithm>
#include <system_error>

#include "common/record/file.hpp"
#include "host/recordings/recording_summary.hpp"

namespace roadbalance {
namespace {

/// Time of the last change of a segment; nothing: the folder holds none.
std::optional<RecordingsList::FileTime> last_change(const std::filesystem::path& folder) {
  std::optional<RecordingsList::FileTime> newest;
  std::error_code error;
  for (const auto& file : std::filesystem::directory_iterator(folder, error)) {
    if (file.path().extension() != ".lcm") continue;
    const auto changed = file.last_write_time(error);
    if (!error && (!newest || changed > *newest)) newest = changed;
  }
  return newest;
}

/// Its writer has it locked, or the disk has no locks that would show it.
bool may_be_locked(const std::filesystem::path& folder) {
  try {
    File file = File::open_folder(folder);
    return try_lock(file) != true;
  } catch (const std::system_error&) {
    return false;
  }
}

constexpr const char* kHalfMade = ".part";

}  // namespace

void RecordingsList::look_in(const std::filesystem::path& place, bool is_results, FileTime now,
                             std::map<std::string, Entry>& found) {
  std::error_code error;
  for (const auto& each : std::filesystem::directory_iterator(place, error)) {
    if (!each.is_directory(error) || each.path().extension() == kHalfMade) continue;
    const auto changed = last_change(each.path());
    if (!changed) continue;
    std::string name = each.path().filename().string();
    while (found.contains(name)) name += kOfResults;
    const auto known = entry_.find(name);
    Entry& entry = found[name];
    if (known != entry_.end() && known->second.folder == each.path()) entry = std::move(known->second);
    entry.grows = !is_results && now - *changed < kQuiet && may_be_locked(each.path());
    if (entry.changed != *changed || entry.grows) {
      entry.folder = each.path();
      entry.summary = unread(each.path());
      entry.read.reset();
    }
    entry.changed = *changed;
    entry.summary.name = name;
    if (!entry.read) entry.summary.state = entry.grows ? RecordingState::kGrowing : RecordingState::kNotRead;
  }
}

void RecordingsList::look(FileTime now) {
  std::map<std::string, Entry> found;
  look_in(folder_, false, now, found);
  if (!results_.empty()) look_in(results_, true, now, found);
  entry_ = std::move(found);
  newest_first_.clear();
  for (const auto& [name, entry] : entry_) newest_first_.push_back(name);
  std::ranges::stable_sort(newest_first_, std::ranges::greater{},
                           [&](const std::string& name) { return entry_[name].changed; });
  if (newest_first_.size() > static_cast<std::size_t>(kMostRecordings)) newest_first_.resize(kMostRecordings);
}

bool RecordingsList::grows() const {
  return std::ranges::any_of(entry_, [](const auto& entry) { return entry.second.grows; });
}

std::optional<std::filesystem::path> RecordingsList::unread_one() {
  if (grows()) return std::nullopt;
  for (const std::string& name : newest_first_) {
    Entry& entry = entry_.at(name);
    if (entry.read) continue;
    entry.wanted = entry.changed;
    return entry.folder;
  }
  return std::nullopt;
}

void RecordingsList::take(RecordingSummary summary) {
  const auto found = std::ranges::find_if(entry_, [&](const auto& entry) {
    return entry.second.folder == std::filesystem::path(summary.place) / summary.name;
  });
  if (found == entry_.end() || found->second.grows) return;
  if (found->second.wanted != found->second.changed) return;
  found->second.read = found->second.changed;
  found->second.summary = std::move(summary);
  found->second.summary.name = found->first;
}

std::vector<ListedRecording> RecordingsList::listed() const {
  std::vector<ListedRecording> all;
  for (const std::string& name : newest_first_) {
    const Entry& entry = entry_.at(name);
    all.push_back({entry.summary, entry.folder});
  }
  return all;
}

std::vector<RecordingSummary> RecordingsList::reported() const {
  if (newest_first_.empty()) return {RecordingSummary{.name = "", .vehicle = ""}};
  std::vector<RecordingSummary> reported;
  for (const std::string& name : newest_first_) {
    RecordingSummary& summary = reported.emplace_back(entry_.at(name).summary);
    summary.number = static_cast<std::int32_t>(reported.size()) - 1;
    summary.recordings = static_cast<std::int32_t>(newest_first_.size());
  }
  return reported;
}

}  // namespace roadbalance

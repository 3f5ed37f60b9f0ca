#include "host/receipts/recordings_list.hpp"

#include <algorithm>
#include <system_error>

#include "host/receipts/receipt.hpp"

namespace roadbalance {
namespace {

/// When a segment last changed; nothing: it holds none.
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

}  // namespace

void RecordingsList::look(FileTime now) {
  std::map<std::string, Entry> found;
  std::error_code error;
  for (const auto& place : std::filesystem::directory_iterator(folder_, error)) {
    if (!place.is_directory(error)) continue;
    const auto changed = last_change(place.path());
    if (!changed) continue;
    const std::string name = place.path().filename().string();
    const auto known = entry_.find(name);
    Entry& entry = found[name];
    if (known != entry_.end()) entry = std::move(known->second);
    entry.grows = now - *changed < kQuiet;
    if (entry.changed != *changed || entry.grows) {
      entry.receipt = unread(place.path());
      entry.read.reset();
    }
    entry.changed = *changed;
    if (!entry.read) entry.receipt.state = entry.grows ? RecordingState::kGrowing : RecordingState::kNotRead;
  }
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
    return folder_ / name;
  }
  return std::nullopt;
}

void RecordingsList::take(RecordingReceipt receipt) {
  const auto found = entry_.find(receipt.name);
  if (found == entry_.end() || found->second.grows) return;
  if (found->second.wanted != found->second.changed) return;
  found->second.read = found->second.changed;
  found->second.receipt = std::move(receipt);
}

std::vector<RecordingReceipt> RecordingsList::told() const {
  if (newest_first_.empty()) return {RecordingReceipt{.name = "", .vehicle = ""}};
  std::vector<RecordingReceipt> told;
  for (const std::string& name : newest_first_) {
    RecordingReceipt& receipt = told.emplace_back(entry_.at(name).receipt);
    receipt.number = static_cast<std::int32_t>(told.size()) - 1;
    receipt.recordings = static_cast<std::int32_t>(newest_first_.size());
  }
  return told;
}

}  // namespace roadbalance

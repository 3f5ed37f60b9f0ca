#include <array>
#include <cerrno>
#include <limits>
#include <string>
#include <system_error>
#include <utility>

#include "common/record/folder.hpp"
#include "common/record/record.hpp"
#include "common/record/segment.hpp"
#include "hil_tests/deterministic/host_machine.hpp"
#include "host/recorder/manifest.hpp"
#include "host/recorder/verify.hpp"
#include "host/recorder/verify_missing.hpp"
#include "tools/rb/salvage.hpp"

namespace roadbalance::test {

void HostMachine::fill_disk(bool full) {
  const std::int64_t left = random_.below(20 << 20);
  full_ = full;
  if (!full) refused_at_ns_ = now_ns_;  // perhaps
  disk_.set_capacity(full ? disk_.used_bytes() + left : std::numeric_limits<std::int64_t>::max() / 2);
}

std::int64_t HostMachine::take_elapsed_ns() {
  const std::int64_t all_ns = disk_.busy().count();
  return all_ns - std::exchange(elapsed_seen_ns_, all_ns);
}

SimulatedDisk::Outcome HostMachine::disk_call(DiskCall call, const std::string& path) {
  if (died_)
    return {.error = EIO};  // what is left of it until its turn ends does nothing, new files included
  const bool counts = !dies_at_sync_ || call == DiskCall::kSyncData || call == DiskCall::kSync;
  if (calls_to_live_ > 0 && counts && --calls_to_live_ == 0) {
    died_ = true;
    ++deaths_at_call_;
    if (dies_of_power_) return {.power_cut = true};
    disk_.kill();  // this call and all that follow do nothing, and nobody hears of them
    return {};
  }
  const bool on_other_disk = scenario_.fallback && !path.starts_with(kFolder);
  // The kernel knows by itself what a path leads to.
  const bool can_fail = call != DiskCall::kClose && call != DiskCall::kIdentity && !on_other_disk;
  if (!can_fail || !random_.chance(failing_)) return {};
  refused_at_ns_ = now_ns_;
  constexpr std::array kErrors{EIO, ENOSPC, EROFS, EINTR};
  const auto which = static_cast<std::size_t>(random_.below(kErrors.size() + 1));
  if (which == kErrors.size()) return {.short_write = true};
  return {.error = kErrors[which]};
}

std::chrono::nanoseconds HostMachine::disk_cost(DiskCall call, std::size_t bytes) {
  constexpr double kBytes_s = 200e6;
  double seconds = static_cast<double>(bytes) / kBytes_s;
  if (call == DiskCall::kSyncData || call == DiskCall::kSync) {
    seconds += random_.between(0.001, 0.03);
    if (random_.chance(scenario_.slow_syncs))
      seconds += random_.between(scenario_.slow_sync.shortest_s, scenario_.slow_sync.longest_s);
  }
  return std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

// Segments with several behind them are finished: nothing is added, cut or said of them any more.
void HostMachine::check_finished() {
  constexpr int kBehind = 4;
  if (boots_ == 0 || disk_.is_off() || scenario_.fallback || scenario_.is_operated()) return;
  // The check's own calls are none of the recorder's.
  const double failing = std::exchange(failing_, 0);
  const int calls_to_live = std::exchange(calls_to_live_, 0);
  const auto numbers = segment_numbers(kFolder, disk_);
  if (!numbers.empty()) check_through(kFolder, numbers.back() - kBehind);
  failing_ = failing;
  calls_to_live_ = calls_to_live;
}

void HostMachine::check_record() {
  if (boots_ == 0) return;
  disk_.power_on();
  failing_ = 0;
  if (scenario_.is_operated()) return check_recordings();
  if (fell_back()) make_whole();
  check_through(record_folder(), std::numeric_limits<int>::max());
  check_segments(record_folder());
  clock_events_.finish();
}

bool HostMachine::fell_back() {
  return is_folder(kFallback, disk_) && !segment_numbers(kFallback, disk_).empty();
}

// As rb recover DIR --spool FALLBACK does.
void HostMachine::make_whole() {
  try {
    const Salvaged salvaged = salvage({kFolder, kFallback}, kWhole, disk_);
    if (salvaged.gaps > 0 || salvaged.blocks_altered > 0)
      truth_.fault("the two folders of recorder " + std::to_string(number_) + " together lack " +
                   std::to_string(salvaged.gaps) + " runs of blocks; " +
                   std::to_string(salvaged.blocks_altered) + " are altered");
    for (const std::string& line : salvaged.lost)
      truth_.fault("rb recover would say that the two folders of recorder " + std::to_string(number_) +
                   " lack " + line);
    if (verify_record(kWhole, disk_).verdict == Verdict::kDamaged)
      truth_.fault("rb verify calls damaged what rb recover made of the two folders of recorder " +
                   std::to_string(number_));
    for (const char* folder : {kFolder, kFallback})
      if (verify_record(folder, disk_).verdict == Verdict::kDamaged)
        truth_.fault("rb verify calls " + std::string(folder) + " of recorder " + std::to_string(number_) +
                     " damaged, of which the rest is in another folder");
  } catch (const std::exception& error) {
    truth_.fault("the two folders of recorder " + std::to_string(number_) + ": " + error.what());
  }
}

// What the product's own check says of segments: the record is whole, so none may be said to be missing.
void HostMachine::check_segments(const char* folder) {
  if (!is_folder(folder, disk_)) return;
  for (const std::string& line :
       find_missing_segments(folder, read_manifest(folder, disk_), deleted_, disk_).lines)
    truth_.fault("rb verify would say of the record of recorder " + std::to_string(number_) + ": " + line);
}

void HostMachine::check_through(const char* folder, int last) {
  if (last < next_to_check_) return;
  const bool all = last == std::numeric_limits<int>::max();
  const std::string name = "record " + (checked_.empty() ? "" : "\"" + checked_ + "\" ") + "of recorder " +
                           std::to_string(number_) + ": ";
  try {
    // A recorder that nobody obeyed has none; what one promised is held against what was read in any case.
    if (next_to_check_ == 1 && segment_numbers(folder, disk_).empty()) return;
    RecordReader reader(folder, disk_, next_to_check_);
    if (all) reader.finish();
    const auto has_ended = [this](const NodeEpoch& key) { return check_.is_closed(key.first, key.second); };
    int segment = 0;
    while (const auto event = reader.next()) {
      if (reader.segment() > last) break;
      if (std::exchange(segment, reader.segment()) != segment)
        clock_events_.begin_segment(segment, has_ended);
      check_.take(event->channel, event->data, checked_);
      if (event->channel == kNoteChannel) take_notes(checked_, event->data);
      clock_events_.take(event->channel, event->data);
    }
    next_to_check_ = all ? last : last + 1;
    for (const auto& damage : reader.damage()) {
      if (damage.torn && may_be_torn_.contains(checked_)) continue;
      truth_.fault(name + std::to_string(damage.bytes) + " bytes of " + damage.segment.filename().string() +
                   " from " + std::to_string(damage.offset) + " on " + damage.what);
    }
  } catch (const std::system_error& error) {
    truth_.fault(name + error.what());
  }
  take_elapsed_ns();  // nobody waits for the check
}

}  // namespace roadbalance::test

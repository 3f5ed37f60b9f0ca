#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/link/epoch_receiver.hpp"
#include "common/record/record_writer.hpp"
#include "common/types/clocks.hpp"
#include "host/recorder/ballast.hpp"
#include "host/recorder/epoch_sums.hpp"
#include "host/recorder/failure_policy.hpp"
#include "host/recorder/held_events.hpp"
#include "host/recorder/recorder_link.hpp"
#include "host/recorder/segment_retention.hpp"
#include "host/recorder/space_watch.hpp"
#include "host/recorder/store_folders.hpp"
#include "host/recorder/store_journal.hpp"
#include "host/recorder/store_options.hpp"

namespace roadbalance {

/// Deliveries -> disk: appends in the order given, commits as a group, and only then reports durable.
/// A pure state machine around a Disk; time comes in with every call.
///
/// After the constructor a disk that fails is a state, never an exception.  A segment that failed is not
/// written to again; all since the last durable mark is held here and written again into a new one, so that
/// nothing is lost even if the nodes die meanwhile.  Two failures in ten seconds: no credit, and a new try
/// each second, from the third on in the fallback folder if there is one.  A full disk: no credit until space
/// returns.
///
/// While the disk fails nothing is held open on it, so that it can be unmounted and repaired.  One that is
/// unmounted while it is written is a failing disk.  Recording goes on once all that is durable is found at
/// the folder's path again: whatever else lies there, of another disk, is left alone.  If a person removed
/// the segment or the folder, the rest is recorded; its content is missing, and declared so.
///
/// Memory: what credit lets arrive between two syncs, and other events as HeldEvents bounds them; dropped
/// ones are declared in the record.  Marks and the notes of this store about the record itself are always
/// kept: they are few, and readers rely on them.
class RecordingStore {
 public:
  /// Creates the folder or continues one: locks it, cuts a torn tail, takes what it holds, and stores the
  /// recorder's number (next_incarnation()).  The fallback is continued if it holds the rest of this record,
  /// and taken if the folder cannot be written, or not even read.
  /// @throws std::invalid_argument if the fallback holds another recording, std::system_error naming the
  ///         file, std::runtime_error if another recorder writes to the folder, if the record goes on in a
  ///         fallback that is not named, or if what is stored is no number
  RecordingStore(Disk& disk, StoreOptions options);
  RecordingStore(const RecordingStore&) = delete;
  RecordingStore& operator=(const RecordingStore&) = delete;

  /// The content of the folders at the start.
  const RecordState& recovered() const { return recovered_; }
  /// The one that is written to.
  const std::filesystem::path& folder() const { return folders_.folder(); }
  /// The recorder's number in this run, stored in the folder.
  std::int64_t incarnation() const { return stamp_.incarnation; }
  /// Tails that were cut off at the start: of the first folder, and of the fallback.
  const std::vector<RecordWriter::CutTail>& cut_tails() const { return folders_.cut_tails(); }

  /// The host's clocks at this instant; entries are stamped with the pair given last.  A wall clock that was
  /// set and a sleep of the computer become notes.
  /// @param slept  as MachineClock::slept(), which host_ns counts, too
  void set_clocks(std::int64_t utc_us, std::int64_t host_ns, MachineClock::duration slept = {});
  /// The first notes: that the recorder runs, and, if so, that tails were cut.
  void begin();

  void set_link_counters(LinkCounters counters) { journal_.set_link_counters(std::move(counters)); }

  void append(const Delivery& delivery, WallTime now);
  void append(const RecordEvent& event, WallTime now);
  /// Notes an event; it is in the record with the next commit, but no recording begins for notes alone.
  /// @param age  of the event
  void note(NoteKind kind, std::int64_t a, std::int64_t b, std::string text,
            std::chrono::nanoseconds age = {});
  /// Commits and closes the segment: the power may go, so that a failing disk is tried at once.  The next
  /// block begins another.
  std::vector<DurableMark> seal(WallTime now);

  /// commit() has something to do.
  bool commit_is_due(WallTime now) const;
  /// Until a commit is due if nothing more comes.
  std::chrono::milliseconds time_left(WallTime now) const;
  /// @return newly durable blocks
  std::vector<DurableMark> commit(WallTime now);
  /// Work that can wait: finishes the segment before, lists it in the manifest, deletes a segment that
  /// retention has chosen and a note on the disk declares.  One of these a call, of three syncs at most, for
  /// blocks wait meanwhile.  To be called when no commit is due and the marks that commit() returned have
  /// been passed on; seal() and close() do all of it.
  void maintain();
  /// As seal(), for the last time. failure() is why something could not be made durable.  A disk that fails
  /// while the last notes are written leaves a torn tail without blocks.
  std::vector<DurableMark> close(WallTime now);

  RecorderState state() const;
  bool wants_credit() const { return state() == RecorderState::kRecording; }
  /// Blocks wait and this is why they are not on the disk.
  std::optional<std::string> failure() const;
  /// The number of the last mark that is on the disk.
  std::int32_t durable_marks() const { return static_cast<std::int32_t>(last_durable_mark_); }
  /// Fills in the disk side of the status.
  void fill(RecorderStatus& status) const;
  /// Sentences for people, since the last call.
  std::vector<std::string> warnings() { return std::exchange(warnings_, {}); }

 private:
  void check_sum(const SealedBlock& block);
  bool has_blocks() const { return !folders_.holds().epoch.empty(); }
  bool has_new_mark() const { return last_mark_ > last_durable_mark_; }
  bool may_write(WallTime now) const;
  template <typename Call>
  bool attempt(WallTime now, Call&& call);
  void fail(const std::system_error& error, WallTime now);
  bool write_held(WallTime now);
  void hold_anew();
  std::vector<DurableMark> all_is_durable();
  void declare_dropped(std::int64_t count, const char* what);
  void do_duties(WallTime now);
  void write_journal();
  std::int64_t epochs_held() const;
  void watch_space(WallTime now);
  void on_space(SpaceWatch::Event event);

  Disk& disk_;
  const StoreOptions options_;
  std::vector<std::string> warnings_;
  Ballast ballast_;
  StoreFolders folders_;
  const RecordState recovered_;
  HeldEvents held_;  // since the last durable mark
  FailurePolicy failures_;
  SpaceWatch space_;
  StoreJournal journal_;
  SegmentRetention retention_;
  EpochSums sums_;                                                         // of the blocks given
  enum class First { kToCome, kWaits, kDurable } first_ = First::kToCome;  // samples
  MachineClock::duration slept_{};
  Note stamp_;            // the clocks and incarnation that notes get
  bool is_lost_ = false;  // what was durable in a folder that was removed, and not yet reported
  bool maintenance_is_due_ = false;
  WallTime duties_at_ = WallTime::min();  // when they are due
  WallTime clock_note_at_ = WallTime::min();
  WallTime journal_at_ = WallTime::min();
  std::int64_t bytes_recorded_ = 0;
  std::int64_t last_mark_ = 0, last_durable_mark_ = 0;  // numbers, which rise
};

}  // namespace roadbalance

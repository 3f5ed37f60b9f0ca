#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/clock/clocks.hpp"
#include "common/link/epoch_receiver.hpp"
#include "common/record/journal_tally.hpp"
#include "common/record/record.hpp"
#include "host/recorder/ballast.hpp"
#include "host/recorder/disk_health.hpp"
#include "host/recorder/epoch_sums.hpp"
#include "host/recorder/held_events.hpp"
#include "host/recorder/keeper_options.hpp"
#include "host/recorder/recorder_link.hpp"
#include "host/recorder/space_watch.hpp"

namespace roadbalance {

/// Anything else that the record keeps: clock exchanges and fits.
struct RecordEvent {
  std::string channel;
  std::vector<std::uint8_t> bytes;
  std::int64_t dropped_before{};  ///< events since the one before that found no room on their way here
};

/// Deliveries -> disk: appends in the order given, commits as a group, and only then says durable.
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
/// the folder's path again: whatever else lies there, of another disk, is left alone.  Of a segment or folder
/// that somebody removed the rest is recorded; what was in it is missing, and said to be.
///
/// Memory: what credit lets arrive between two syncs, and at most 16 MiB of other events.  Of notes of
/// devices, of alarms and of what was asked so many are held as kMostHeldNotes says; what is dropped is
/// declared in the record. Marks and what this keeper says of the record itself are always kept: they are
/// few, and readers rely on them.
class RecordKeeper {
 public:
  static constexpr int kMostHeldNotes = 1000;

  /// Creates the folder or continues one: locks it, cuts a torn tail, takes what it holds, and stores the
  /// recorder's number (next_incarnation()).  The fallback is continued if it holds the rest of this record,
  /// and taken if the folder cannot be written, or not even read.
  /// @throws std::invalid_argument if the fallback holds another recording, std::system_error naming the
  ///         file, std::runtime_error if another recorder writes to the folder, if the record goes on in a
  ///         fallback that is not named, or if what is stored is no number
  RecordKeeper(Disk& disk, KeeperOptions options);
  RecordKeeper(const RecordKeeper&) = delete;
  RecordKeeper& operator=(const RecordKeeper&) = delete;

  /// What the folders held at the start.
  const RecordState& recovered() const { return recovered_; }
  /// The one that is written to.
  const std::filesystem::path& folder() const { return fallback_ ? options_.fallback : options_.folder; }
  /// The recorder's number in this run, stored in the folder.
  std::int64_t incarnation() const { return stamp_.incarnation; }
  /// What was cut off at the start: of the first folder, and of the fallback.
  const std::vector<RecordWriter::CutTail>& cut_tails() const { return cut_tails_; }

  /// The host's clocks at this instant; entries are stamped with the pair given last.
  void set_clocks(std::int64_t utc_us, std::int64_t host_ns);
  /// The first notes: that the recorder runs, and, if so, that tails were cut.
  void begin();

  void set_link_counters(LinkCounters counters) { counters_ = std::move(counters); }

  void append(const Delivery& delivery, WallTime now);
  void append(const RecordEvent& event, WallTime now);
  /// What happened; in the record with the next commit, but no recording begins for notes alone.
  /// @param age  so long ago it happened
  void note(NoteKind kind, std::int64_t a, std::int64_t b, std::string text,
            std::chrono::nanoseconds age = {});
  /// Commits and closes the segment: the power may go, so that a failing disk is tried at once.  The next
  /// block begins another.
  std::vector<DurableMark> seal(WallTime now);

  /// commit() has something to do.
  bool commit_is_due(WallTime now) const;
  /// Until a commit is due if nothing more comes.
  std::chrono::milliseconds time_left(WallTime now) const;
  /// What is durable now and was not before.
  std::vector<DurableMark> commit(WallTime now);
  /// What can wait: finishes the segment before, lists it in the manifest, deletes what retention has chosen
  /// and a note on the disk tells of.  One of these a call, of three syncs at most, for what comes meanwhile
  /// waits. To be called when no commit is due and what commit() returned has been passed on; seal() and
  /// close() do all of it.
  void keep_house();
  /// As seal(), for the last time.  What could not be made durable is said by failure().
  std::vector<DurableMark> close(WallTime now);

  RecorderState state() const;
  bool wants_credit() const { return state() == RecorderState::kRecording; }
  /// Blocks wait and this is why they are not on the disk.
  std::optional<std::string> failure() const;
  /// The number of the last mark that is on the disk.
  std::int32_t durable_marks() const { return static_cast<std::int32_t>(last_durable_mark_); }
  /// Fills in what the disk side of the recorder knows.
  void fill(RecorderStatus& status) const;
  /// Sentences for people, since the last call.
  std::vector<std::string> warnings() { return std::exchange(warnings_, {}); }

 private:
  void check_sum(const SealedBlock& block);
  bool has_memory_for(NoteKind kind);
  bool has_blocks() const { return !writer_->holds().epoch.empty(); }
  void declare_dropped(std::int64_t count, const char* what);
  bool is_caught_up() const { return written_ == held_.size(); }
  template <typename Call>
  bool attempt(WallTime now, Call&& call);
  void fail(const std::system_error& error, WallTime now);
  bool may_write(WallTime now) const;
  bool write_held(WallTime now);
  std::vector<DurableMark> all_is_durable();
  // keeper_folders.cpp: where the record is.
  void open_folders();
  void open_first();
  bool is_known_and_missing() const;
  void open(const std::filesystem::path& folder, RecordState before);
  void keep_cut_tail();
  RecordState held_by_first(std::vector<UnsureBlock>& unsure);
  void store_incarnation();
  void go_to_fallback(WallTime now);
  void hold_anew();
  void say_where_it_goes_on();
  void sync();
  void require_its_place() const;
  bool lies_elsewhere() const;
  bool is_its_disk_there() const;
  bool holds_this_recording() const;
  void come_back();
  void begin_anew();
  // keeper_duties.cpp: what is done beside, some time before or after a commit.
  void do_duties(WallTime now);
  void keep_journal();
  std::vector<NodeEpoch> journal_due() const;
  std::int64_t epochs_held() const;
  void watch_space(WallTime now);
  void on_space(SpaceWatch::Event event);
  bool list_finished();
  void choose_segments_to_delete();
  bool delete_segment_told();

  Disk& disk_;
  const KeeperOptions options_;
  std::optional<RecordWriter> writer_;
  bool fallback_ = false;
  std::int64_t device_ = -1;  // that folder() lies on
  RecordState recovered_;
  std::vector<RecordWriter::CutTail> cut_tails_;
  Note stamp_;  // the clocks and incarnation that notes get

  HeldEvents held_;                            // since the last durable mark
  std::size_t written_ = 0;                    // of held_: appended to the writer
  std::int64_t appended_before_ = 0;           // the writer's count when held_ was empty
  std::map<NodeEpoch, std::int64_t> pending_;  // the last sequence in held_
  std::int64_t held_blocks_ = 0;
  WallTime oldest_{};  // when the first of them came
  bool urgent_ = false;
  bool segment_is_open_ = false;
  bool is_removed_ = false;          // the folder or the segment, while its disk was there
  bool is_lost_ = false;             // what was durable in a folder that was removed, and not yet told
  int notes_held_ = 0;               // of those that may be dropped
  bool has_news_ = false;            // notes are held that begin a segment of a recording that has blocks
  std::int64_t events_dropped_ = 0;  // and not yet told
  std::int64_t notes_dropped_ = 0;   // and not yet told

  DiskHealth health_;
  int failures_in_a_row_ = 0;
  std::string last_failure_;
  SpaceWatch space_;
  Ballast ballast_;
  WallTime duties_at_ = WallTime::min();  // when they are due
  WallTime clock_note_at_ = WallTime::min();
  WallTime journal_at_ = WallTime::min();
  JournalTally journal_;
  LinkCounters counters_;
  std::map<NodeEpoch, NodeLosses> journalled_;  // by the last entries
  EpochSums sums_;                              // of the blocks given
  bool house_is_due_ = false;
  int listed_ = 0;                 // last segment that the manifest lists as finished
  std::set<int> to_delete_;        // a note says so, which is on the disk after the next commit
  bool deletion_is_told_ = false;  // of all of them
  std::int64_t bytes_recorded_ = 0;
  std::int64_t segments_deleted_ = 0;
  std::int64_t last_mark_ = 0, last_durable_mark_ = 0;  // numbers, which rise
  std::vector<std::string> warnings_;
};

}  // namespace roadbalance

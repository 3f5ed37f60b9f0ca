#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/absence.hpp"
#include "common/bus/operation.hpp"
#include "common/record/disk.hpp"
#include "common/record/file.hpp"

namespace roadbalance {

/// Who asked, and the number of the request.
struct RequestKey {
  std::int64_t asker = 0;
  std::int64_t request = 0;
  bool operator==(const RequestKey&) const = default;
};

struct Mark {
  std::int32_t number = 0;  ///< in its recording, from 1
  RequestKey asked{};
  std::string text{};
};

/// A recording that was started.
struct ActiveRecording {
  std::string name;               ///< of its folder
  std::int64_t began_us = 0;      ///< UTC, as the wall clock was then
  std::int64_t clock_set_us = 0;  ///< by so much that was set since
  RequestKey start{};
  std::vector<std::int32_t> nodes{};   ///< that the start named; empty: every one
  std::vector<std::string> missing{};  ///< nodes that were not there then, in words
  std::vector<Absence> absence{};      ///< so far; to_end: still so, its length is not kept
  std::optional<RequestKey> stop{};    ///< it is to end
  std::string stopped_by{};            ///< for people
  std::int32_t marks = 0;              ///< numbered so far
  std::int32_t durable_marks = 0;      ///< of these, in the record
  std::deque<Mark> mark{};             ///< the latest kMarksRemembered of them
};

/// A node epoch that still holds blocks of a recording that is over: it was cut off when that was stopped.
struct PendingEpoch {
  std::string recording;  ///< of its folder
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  bool operator==(const PendingEpoch&) const = default;
};

/// A recording that is over, by the incarnations that its recorders may have had: by these a node shows whose
/// its epoch is.
struct PastRecording {
  std::string recording;  ///< of its folder
  std::int64_t first_incarnation = 0, last_incarnation = 0;
  bool operator==(const PastRecording&) const = default;
};

/// The lowest that a recorder of this recording may have, above those of recordings before whatever the wall
/// clock is: one that was set back must not make two recordings' incarnations the same.
std::int64_t first_incarnation(const ActiveRecording& recording, const std::vector<PastRecording>& past);

/// The set-up that was asked for last.
struct AskedSetUp {
  RequestKey asked{};
  Operation operation = Operation::kRange;
  std::int32_t node = 0;
  std::int32_t channel = -1;
  std::array<double, 2> value{};
  std::vector<std::int32_t> nodes{};  ///< that are to take it
  std::uint32_t vehicle_crc32c = 0;   ///< of the text that it is to put in force
  AnswerState state = AnswerState::kUnderWay;
  RefusalReason reason = RefusalReason::kNone;
  std::string text{};  ///< the last answer's
  bool operator==(const AskedSetUp&) const = default;
};

/// The recording that was ended last.
struct Finished {
  RequestKey start{}, stop{};
  std::vector<Receipt> receipt{};  ///< of each node
  std::int32_t durable_marks = 0;  ///< in the record
  std::deque<Mark> mark{};         ///< the latest, as when it ended
};

/// Everything that a recorder which takes requests must have after a crash: a recording that is under way
/// goes on, and a request that was obeyed is not obeyed again.
struct SessionState {
  std::optional<ActiveRecording> active{};
  std::optional<Finished> finished{};
  /// To be fetched when their nodes are back; the latest kMostPendingEpochs.
  std::vector<PendingEpoch> pending{};
  std::vector<PastRecording> past{};  ///< the latest kMostPast
  std::optional<AskedSetUp> set_up{};
  /// Those asked before it, each with its last word: an asker that has not heard it repeats the request, and
  /// is not to set up anew what another has changed since.  The latest kMostSetUps.
  std::vector<AskedSetUp> set_up_before{};

  /// Nothing: none that is remembered was asked so.
  const AskedSetUp* set_up_asked(const RequestKey& key) const;
  /// It is the last one from now on.
  void add(AskedSetUp asked);
};

inline constexpr const char* kSessionStateFile = "recorder.json";
/// Beside it: which vehicle file was chosen last.
inline constexpr const char* kVehicleFile = "vehicle";
inline constexpr std::size_t kMarksRemembered = 32;
inline constexpr std::size_t kMostPendingEpochs = 256;
inline constexpr std::size_t kMostPast = 64;
inline constexpr std::size_t kMostSetUps = 32;

/// As long as it lives no other recorder gets it: two would answer every request, and write one session
/// state.
/// @throws std::runtime_error naming the folder if another has it; std::system_error
File claim_session_state(const std::filesystem::path& recordings, Disk& disk = kernel_disk());
/// An empty state if there is no file.  @throws std::runtime_error naming the file if it is none
SessionState read_session_state(const std::filesystem::path& recordings, Disk& disk = kernel_disk());
/// The text of its file.
std::string text_of(const SessionState& state);
/// Durable on return.  @throws std::system_error naming the file
void write_session_state(const std::filesystem::path& recordings, const SessionState& state,
                         Disk& disk = kernel_disk());

/// Why a recording cannot be called so; empty: it can.  It becomes the name of a folder.
std::string fault_of_name(const std::string& name);
/// The same of a recording to be made, which people will copy to other systems.
std::string fault_of_new_name(const std::string& name);

/// The name of what keeps a new recording from this folder; empty: nothing does.  One in which a start came
/// to nothing may be had again, but not if nodes may hold a rest of it, or its fallback may.  A name that
/// differs from another by capitals only, here or beside the fallback, is taken: other systems would take the
/// two for one.
/// @param fallback  of this recording; empty: none
/// @throws std::system_error
std::string taken_by(const std::filesystem::path& folder, const std::filesystem::path& fallback,
                     const std::vector<PastRecording>& past, Disk& disk = kernel_disk());

}  // namespace roadbalance

#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/operation.hpp"
#include "common/record/disk.hpp"
#include "common/record/file.hpp"

namespace roadbalance {

/// Who asked, and the number of what he asked.
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

/// A recording that somebody wants.
struct UnderWay {
  std::string name;           ///< of its folder
  std::int64_t began_us = 0;  ///< UTC
  RequestKey start{};
  std::optional<RequestKey> stop{};  ///< it is to end
  std::int32_t marks = 0;            ///< numbered so far
  std::int32_t durable_marks = 0;    ///< of these, in the record
  std::deque<Mark> mark{};           ///< the latest kMarksRemembered of them
};

/// What a node epoch still holds of a recording that is over: it was cut off when that was stopped.
struct Rest {
  std::string recording;  ///< of its folder
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  bool operator==(const Rest&) const = default;
};

/// A recording that is over, by the incarnations that its recorders may have had: by these a node tells whose
/// its epoch is.
struct Over {
  std::string recording;  ///< of its folder
  std::int64_t first_incarnation = 0, last_incarnation = 0;
  bool operator==(const Over&) const = default;
};

/// The lowest that a recorder of this recording may have, above those of recordings before whatever the wall
/// clock says: one that was set back must not make two recordings' incarnations the same.
std::int64_t first_incarnation(const UnderWay& recording, const std::vector<Over>& over);

/// Set-up that somebody asked for last.
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

/// What a recorder that takes requests must know after a crash: a recording that is under way goes on, and a
/// request that was obeyed is not obeyed again.
struct DeskBook {
  std::optional<UnderWay> under_way{};
  std::optional<Finished> finished{};
  std::vector<Rest> rest{};  ///< to be fetched when its node is back; the latest kMostRests
  std::vector<Over> over{};  ///< the latest kMostOver
  std::optional<AskedSetUp> set_up{};
  /// Those asked before it, each with its last word: whoever has not heard it repeats the request, and is not
  /// to set up anew what another has changed since.  The latest kMostSetUps.
  std::vector<AskedSetUp> set_up_before{};

  /// Nothing: none that is remembered was asked so.
  const AskedSetUp* set_up_asked(const RequestKey& key) const;
  /// It is the last one from now on.
  void add(AskedSetUp asked);
};

inline constexpr const char* kDeskBookFile = "recorder.json";
/// Beside it: which vehicle file was chosen last.
inline constexpr const char* kVehicleFile = "vehicle";
inline constexpr std::size_t kMarksRemembered = 32;
inline constexpr std::size_t kMostRests = 256;
inline constexpr std::size_t kMostOver = 64;
inline constexpr std::size_t kMostSetUps = 32;

/// As long as it lives no other recorder gets it: two would answer every request, and write one book.
/// @throws std::runtime_error naming the folder if another has it; std::system_error
File claim_desk_book(const std::filesystem::path& recordings, Disk& disk = kernel_disk());
/// An empty book if there is no file.  @throws std::runtime_error naming the file if it is no book
DeskBook read_desk_book(const std::filesystem::path& recordings, Disk& disk = kernel_disk());
/// What stands in its file.
std::string text_of(const DeskBook& book);
/// Durable on return.  @throws std::system_error naming the file
void write_desk_book(const std::filesystem::path& recordings, const DeskBook& book,
                     Disk& disk = kernel_disk());

/// Why a recording cannot be called so; empty: it can.  It becomes the name of a folder.
std::string fault_of_name(const std::string& name);

/// Whether a new recording may not have this folder, for something else is there.  One in which a start came
/// to nothing may be had again, but not if nodes may hold a rest of it, or its fallback may.
/// @param fallback  of this recording; empty: none
/// @throws std::system_error
bool is_taken(const std::filesystem::path& folder, const std::filesystem::path& fallback,
              const std::vector<Over>& over, Disk& disk = kernel_disk());

}  // namespace roadbalance

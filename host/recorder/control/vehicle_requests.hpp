#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/bus/operation.hpp"
#include "common/bus/publish.hpp"
#include "common/record/disk.hpp"
#include "common/types/block.hpp"
#include "common/types/clocks.hpp"
#include "host/recorder/control/mark_readings.hpp"
#include "host/recorder/control/recordings_folder.hpp"
#include "host/recorder/control/session_state.hpp"
#include "host/recorder/control/set_up.hpp"

namespace roadbalance {

/// Answers requests about the vehicle, by a SetUp and MarkReadings; without a vehicle file, or with a broken
/// one, refuses them and gives the reason.
class VehicleRequests {
 public:
  /// Reads the vehicle file and goes on with a set-up that the session state has under way.  A file that is
  /// broken must not end a recording that is under way: that goes on without.
  /// @param vehicle     empty: none
  /// @param recordings  as SetUp takes them
  /// @return  the state, in which a set-up is refused that cannot go on
  /// @throws as SetUp, if no recording is under way
  SessionState begin(const std::filesystem::path& vehicle, const std::filesystem::path& recordings,
                     std::uint64_t seed, Disk& disk, SessionState state, std::int64_t utc_us, WallTime now,
                     const RecordingsFolder::Warn& warn);

  /// Takes a message of any channel; replies, previews and, while a zero mark is read, blocks count.
  void take(std::string_view channel, std::span<const std::uint8_t> bytes, WallTime now);
  /// Changes the vehicle file, between recordings.
  /// @param nodes  that are there
  Answer set_up(const Request& request, const std::vector<std::int32_t>& nodes, std::int64_t utc_us,
                WallTime now);
  /// Operation::kReading, while a recording is under way.
  Answer read_mark(const Request& request, std::int64_t utc_us, WallTime now);
  /// The recording has ended: its readings count for nothing.
  void forget_marks() { mark_readings_.forget(); }

  /// Sends what is due.  @return the last word on what was under way, once
  std::optional<Answer> turn(const Publish& publish, std::int64_t utc_us, WallTime now);
  bool is_set_up_under_way() const { return set_up_ && set_up_->is_under_way(); }
  /// That leads the vehicle file; nothing: there is none.
  std::optional<SetUp>& leading() { return set_up_; }
  const std::optional<SetUp>& leading() const { return set_up_; }

 private:
  Answer no_vehicle(const Request& request, std::int64_t utc_us) const;

  std::optional<SetUp> set_up_;
  std::string no_set_up_ = "this recorder leads no vehicle file: start rb-recorder with --vehicle FILE";
  MarkReadings mark_readings_;
  SealedBlock block_;
};

}  // namespace roadbalance

#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>

#include "common/record/disk.hpp"
#include "common/record/file.hpp"
#include "common/types/clocks.hpp"
#include "host/recorder/control/session_state.hpp"

namespace roadbalance {

/// The folder of the recordings, claimed for one recorder, and the disk that it is on: stores the session
/// state there, and nowhere else.
///
/// While the recordings' disk is unmounted another's folder lies at its path; nothing is begun there.  A disk
/// that is plugged in anew is another to the kernel: ours is the one that has the session state as it was
/// written last, or was to be.  A recorder that is started while the disk is not mounted cannot see it:
/// rb-recorder.service waits at the start for a disk that /etc/fstab mounts there, as long as systemd does; a
/// disk that comes later is found when there is no work (is_on_another_disk()).
class RecordingsFolder {
 public:
  /// For people.
  using Warn = std::function<void(const std::string&)>;

  /// @throws as claim_session_state()
  RecordingsFolder(std::filesystem::path folder, Disk& disk, Warn warn);

  /// By which the folder is known from now on; written if there is none, for a folder without one could be
  /// any.
  void know_state();
  /// @throws std::system_error
  void store(const SessionState& state);
  /// @throws std::system_error if the folder lies on another disk, or another recorder has it
  void require_its_disk();
  /// Follows the findings of a recording there.  A disk that fails can be unmounted, by a person who repairs
  /// it and by systemd: nothing of it is held open.
  /// @param fails  it is let go of, and claimed again, once a second, when it does not fail any more
  /// @param waits  it is claimed again only when there is something to store
  void follow_disk(bool fails, bool waits, WallTime now);
  /// Another disk was mounted at the folder.
  bool is_on_another_disk() const;

 private:
  bool is_claimed() const { return claim_.is_open() && claim_.is_at(folder_); }

  const std::filesystem::path folder_;
  Disk& disk_;
  const Warn warn_;
  File claim_;
  WallTime claimed_at_{};         // tried to
  std::string claim_fault_;       // why that failed
  std::set<std::string> states_;  // as text; one of them is on the disk
};

}  // namespace roadbalance

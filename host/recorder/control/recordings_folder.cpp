#include "host/recorder/control/recordings_folder.hpp"

#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kClaimAgain{1000};

}  // namespace

RecordingsFolder::RecordingsFolder(std::filesystem::path folder, Disk& disk, Warn warn)
    : folder_(std::move(folder)),
      disk_(disk),
      warn_(std::move(warn)),
      claim_(claim_session_state(folder_, disk)) {}

void RecordingsFolder::know_state() {
  try {
    if (const auto text = read_whole_text(folder_ / kSessionStateFile, disk_)) states_.insert(*text);
    if (states_.empty()) store({});
  } catch (const std::system_error& error) {
    warn_(error.what());
  }
}

void RecordingsFolder::store(const SessionState& state) {
  require_its_disk();
  const std::string text = text_of(state);
  states_.insert(text);
  write_session_state(folder_, state, disk_);
  states_ = {text};
}

void RecordingsFolder::require_its_disk() {
  if (is_claimed()) return;
  const auto text = read_whole_text(folder_ / kSessionStateFile, disk_);
  if (!text || !states_.contains(*text))
    throw std::system_error(ENODEV, std::generic_category(),
                            "recordings " + folder_.string() + " (mount the disk that they are on)");
  claim_ = File();  // it may be the same folder, and is locked once
  try {
    claim_ = claim_session_state(folder_, disk_);
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw std::system_error(EBUSY, std::generic_category(), error.what());
  }
}

void RecordingsFolder::follow_disk(bool fails, bool waits, WallTime now) {
  if (fails) claim_ = File();
  if (fails || claim_.is_open() || waits || now - claimed_at_ < kClaimAgain) return;
  claimed_at_ = now;
  try {
    require_its_disk();
  } catch (const std::system_error& error) {
    if (std::exchange(claim_fault_, error.what()) != error.what()) warn_(claim_fault_);
  }
}

bool RecordingsFolder::is_on_another_disk() const {
  try {
    if (is_claimed()) return false;
  } catch (const std::system_error&) {
    return false;
  }
  const std::filesystem::path above = std::filesystem::absolute(folder_).parent_path();
  const auto folder = disk_.identity(folder_.c_str()), beside = disk_.identity(above.c_str());
  return folder && beside && folder->device != beside->device;
}

}  // namespace roadbalance

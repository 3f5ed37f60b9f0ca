#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "host/recorder/operating.hpp"

// The folder of the recordings, and the disk that it is on.

namespace roadbalance {

// Where the recordings' disk was mounted lies another's folder.  A disk that is plugged in anew is another to
// the kernel: ours has the book as it was written last, or was to be.
void Operating::require_its_folder() {
  if (claim_.is_open() && claim_.is_at(options_.recordings)) return;
  const auto text = read_whole_text(options_.recordings / kDeskBookFile, world_.disk);
  if (!text || !book_texts_.contains(*text))
    throw std::system_error(
        ENODEV, std::generic_category(),
        "recordings " + options_.recordings.string() + " (mount the disk that they are on)");
  claim_ = File();  // it may be the same folder, and is locked once
  try {
    claim_ = claim_desk_book(options_.recordings, world_.disk);
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw std::system_error(EBUSY, std::generic_category(), error.what());
  }
}

// A disk that fails can be unmounted, by the one who repairs it and by systemd: nothing of it is held open.
// While a fallback is recorded to it stays so until there is something to store.
void Operating::follow_disk(bool fails) {
  if (fails) claim_ = File();
  const bool waits = !options_.recorder.fallback.empty() || time_.now - claimed_at_ < kAgain;
  if (fails || claim_.is_open() || waits) return;
  claimed_at_ = time_.now;
  try {
    require_its_folder();
  } catch (const std::system_error& error) {
    if (std::exchange(claim_fault_, error.what()) != error.what()) warn(claim_fault_);
  }
}

bool Operating::has_another_disk() const {
  if (has_work()) return false;
  try {
    if (claim_.is_open() && claim_.is_at(options_.recordings)) return false;
  } catch (const std::system_error&) {
    return false;
  }
  const std::filesystem::path above = std::filesystem::absolute(options_.recordings).parent_path();
  const auto folder = world_.disk.identity(options_.recordings.c_str()),
             beside = world_.disk.identity(above.c_str());
  return folder && beside && folder->device != beside->device;
}

void Operating::store(const DeskBook& book) {
  require_its_folder();
  const std::string text = text_of(book);
  book_texts_.insert(text);
  write_desk_book(options_.recordings, book, world_.disk);
  book_texts_ = {text};
}

}  // namespace roadbalance

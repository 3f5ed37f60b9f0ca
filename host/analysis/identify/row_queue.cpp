#include "host/analysis/identify/row_queue.hpp"

#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <type_traits>

namespace roadbalance {
namespace {

static_assert(std::is_trivially_copyable_v<GridRows>);
constexpr std::size_t kBytes = RowQueue::kBatch * sizeof(GridRows);

off_t place_of(std::int64_t batch) {
  return static_cast<off_t>(batch) * static_cast<off_t>(kBytes);
}

}  // namespace

void RowQueue::push_back(const GridRows& rows) {
  if (back_.empty() && !uses_file() && front_.size() < kInMemory) {
    front_.push_back(rows);
    return;
  }
  back_.push_back(rows);
  if (back_.size() >= 2 * kBatch && !no_file_ && write_batch())
    back_.erase(back_.begin(), back_.begin() + static_cast<std::ptrdiff_t>(kBatch));
}

const GridRows& RowQueue::back() const {
  return back_.empty() ? front_.back() : back_.back();
}

void RowQueue::pop_front() {
  front_.pop_front();
  if (!front_.empty()) return;
  if (uses_file()) {
    read_batch(first_++);
    front_.assign(batch_.begin(), batch_.end());
  } else {
    front_.swap(back_);
  }
}

void RowQueue::pop_back() {
  if (back_.empty()) {
    front_.pop_back();
    return;
  }
  back_.pop_back();
  if (!back_.empty() || !uses_file()) return;
  read_batch(--last_);
  back_.assign(batch_.begin(), batch_.end());
}

void RowQueue::clear() {
  front_.clear();
  back_.clear();
  first_ = last_ = 0;
}

std::size_t RowQueue::size() const {
  return front_.size() + static_cast<std::size_t>(last_ - first_) * kBatch + back_.size();
}

/// The oldest of the back.  False: there can be no file, or no more of it.
bool RowQueue::write_batch() {
  if (!file_) file_.reset(std::tmpfile());
  if (!uses_file()) first_ = last_ = 0;
  batch_.assign(back_.begin(), back_.begin() + static_cast<std::ptrdiff_t>(kBatch));
  const auto size = static_cast<ssize_t>(kBytes);
  const bool written = file_ && pwrite(fileno(file_.get()), batch_.data(), kBytes, place_of(last_)) == size;
  if (written) ++last_;
  no_file_ = !written;
  return written;
}

void RowQueue::read_batch(std::int64_t batch) {
  batch_.resize(kBatch);
  const ssize_t got = pread(fileno(file_.get()), batch_.data(), kBytes, place_of(batch));
  if (got != static_cast<ssize_t>(kBytes))
    throw std::system_error(got < 0 ? errno : EIO, std::generic_category(),
                            "read rows back from the folder for temporary files");
}

}  // namespace roadbalance

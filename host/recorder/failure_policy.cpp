#include "host/recorder/failure_policy.hpp"

#include <cerrno>
#include <utility>

namespace roadbalance {
namespace {

constexpr std::chrono::seconds kTwoInThis{10};
constexpr std::chrono::seconds kTryAgain{1};
constexpr int kReported = 2;  // in a row

}  // namespace

FailurePolicy::Decision FailurePolicy::fail(const std::system_error& error, WallTime now) {
  const bool was_failing = is_failing_;
  ++failures_;
  is_failing_ = is_failing_ || (failed_at_ && now - *failed_at_ < kTwoInThis);
  failed_at_ = now;
  next_try_ = is_failing_ ? now + kTryAgain : now;
  why_ = error.what();
  const std::error_code& code = error.code();
  const bool is_full = code.value() == ENOSPC || code.value() == EDQUOT;
  const bool has_no_place = code == std::errc::no_such_file_or_directory || code == std::errc::no_such_device;
  return {.is_full = is_full,
          .has_no_place = has_no_place,
          .lets_go = (is_failing_ && !is_full) || has_no_place,
          .is_reported = ++failures_in_a_row_ <= kReported,
          .goes_elsewhere = was_failing && !is_full};
}

bool FailurePolicy::succeed() {
  is_failing_ = false;
  return std::exchange(failures_in_a_row_, 0) > 1;
}

}  // namespace roadbalance

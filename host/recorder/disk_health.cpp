#include "host/recorder/disk_health.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::seconds kTwoInThis{10};
constexpr std::chrono::seconds kTryAgain{1};

}  // namespace

void DiskHealth::fail(WallTime now) {
  ++failures_;
  failing_ = failing_ || (failed_at_ && now - *failed_at_ < kTwoInThis);
  failed_at_ = now;
  next_try_ = failing_ ? now + kTryAgain : now;
}

}  // namespace roadbalance

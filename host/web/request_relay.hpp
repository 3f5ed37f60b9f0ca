#pragma once

#include <vector>

#include "common/bus/operation.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// Repeats requests of pages until the recorder has sent the final answer, since the bus may lose either; a
/// pure state machine of bounded memory.  The page gets the answers on its feed.
class RequestRelay {
 public:
  static constexpr std::size_t kMost = 32;  ///< at a time; the oldest is dropped
  static constexpr std::chrono::milliseconds kRepeat{200};
  static constexpr std::chrono::seconds kPatience{60};

  void take(const Request& request, WallTime now);
  void take(const Answer& answer);
  /// The requests to send now.
  std::vector<Request> due(WallTime now);

 private:
  struct Asked {
    Request request;
    WallTime since{};
    WallTime sent_at{};
    bool was_sent = false;
  };
  std::vector<Asked> asked_;
};

}  // namespace roadbalance

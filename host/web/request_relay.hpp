#pragma once

#include <vector>

#include "common/bus/operation.hpp"
#include "common/clock/clocks.hpp"

namespace roadbalance {

/// Repeats what pages ask until the recorder has said its last word of it, for the bus may lose either; a
/// pure state machine of bounded memory.  The page sees the answers on its feed.
class RequestRelay {
 public:
  static constexpr std::size_t kMost = 32;  ///< at a time; the oldest is given up
  static constexpr std::chrono::milliseconds kRepeat{200};
  static constexpr std::chrono::seconds kPatience{60};

  void take(const Request& request, WallTime now);
  void take(const Answer& answer);
  /// To be said now.
  std::vector<Request> due(WallTime now);

 private:
  struct Asked {
    Request request;
    WallTime since{};
    WallTime said_at{};
    bool was_said = false;
  };
  std::vector<Asked> asked_;
};

}  // namespace roadbalance

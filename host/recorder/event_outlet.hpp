#pragma once

#include <cstdint>
#include <utility>

#include "common/process/channel.hpp"
#include "host/recorder/held_events.hpp"

namespace roadbalance {

/// Hands events to the writer and never waits for it: what finds no room is dropped, and the next event
/// that goes through bears their number.
class EventOutlet {
 public:
  explicit EventOutlet(Out<RecordEvent> out) : out_(std::move(out)) {}

  void put(RecordEvent event) {
    event.dropped_before = dropped_;
    dropped_ = out_.try_send(std::move(event)) ? 0 : dropped_ + 1;
  }

 private:
  Out<RecordEvent> out_;
  std::int64_t dropped_ = 0;  // and not yet reported
};

}  // namespace roadbalance

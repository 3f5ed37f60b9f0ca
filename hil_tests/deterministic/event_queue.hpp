#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace roadbalance::test {

/// What happens next in a simulated world.
struct Event {
  enum class Kind : std::uint16_t {
    kDevice,    ///< scans have come at node `who`
    kNodeTurn,  ///< the link process of node `who` looks around
    kHostTurn,  ///< the recorder on host `who` looks around
    kToNode,    ///< datagram `what` arrives
    kToHost,    ///< the same
    kFaultOn,   ///< planned fault `what` begins
    kFaultOff,  ///< and is over
    kClock,     ///< recorder 1 has asked node `who` for the time
    kCheck,     ///< what is finished of the records is held against the truth
    kStop,      ///< the drive is over
  };
  std::int64_t at_ns = 0;
  std::uint32_t order = 0;  ///< of events at the same instant: as they were added
  Kind kind = Kind::kDevice;
  std::uint16_t who = 0;
  std::uint32_t what = 0;
};

/// Events by time.  A binary heap in one vector: no allocation but when it grows beyond its largest size.
class EventQueue {
 public:
  EventQueue() { heap_.reserve(1 << 12); }

  void add(std::int64_t at_ns, Event::Kind kind, std::size_t who, std::size_t what = 0) {
    heap_.push_back({.at_ns = at_ns,
                     .order = order_++,
                     .kind = kind,
                     .who = static_cast<std::uint16_t>(who),
                     .what = static_cast<std::uint32_t>(what)});
    std::push_heap(heap_.begin(), heap_.end(), Later{});
  }

  bool empty() const { return heap_.empty(); }

  Event take() {
    std::pop_heap(heap_.begin(), heap_.end(), Later{});
    const Event event = heap_.back();
    heap_.pop_back();
    return event;
  }

 private:
  // A type, not a function: it is compiled into the loops of the heap.
  struct Later {
    bool operator()(const Event& a, const Event& b) const {
      if (a.at_ns != b.at_ns) return a.at_ns > b.at_ns;
      return static_cast<std::int32_t>(a.order - b.order) > 0;  // the counter may wrap
    }
  };

  std::vector<Event> heap_;
  std::uint32_t order_ = 0;
};

}  // namespace roadbalance::test

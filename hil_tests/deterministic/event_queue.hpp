#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace roadbalance::test {

/// The next event in a simulated world.
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
    kAsker,     ///< asker `who` looks around
    kToAskers,  ///< datagram `what` arrives
  };
  std::int64_t at_ns = 0;
  std::uint32_t order = 0;  ///< of events at the same instant: as they were added
  Kind kind = Kind::kDevice;
  std::uint16_t who = 0;
  std::uint32_t what = 0;
};

/// Events by time.  A binary heap in one vector: no allocation but when it grows beyond its largest size.
///
/// Not std::push_heap and std::pop_heap: these read an event back as a whole as soon as its members are
/// written, which a processor waits for; it was a tenth of a fault run's time.
class EventQueue {
 public:
  EventQueue() { heap_.reserve(1 << 12); }

  void add(std::int64_t at_ns, Event::Kind kind, std::size_t who, std::size_t what = 0) {
    const Event event{.at_ns = at_ns,
                      .order = order_++,
                      .kind = kind,
                      .who = static_cast<std::uint16_t>(who),
                      .what = static_cast<std::uint32_t>(what)};
    std::size_t at = heap_.size();
    heap_.emplace_back();
    for (; at > 0 && is_later(heap_[(at - 1) / 2], event); at = (at - 1) / 2) heap_[at] = heap_[(at - 1) / 2];
    heap_[at] = event;
  }

  bool empty() const { return heap_.empty(); }

  Event take() {
    const Event first = heap_.front();
    const Event last = heap_.back();
    heap_.pop_back();
    if (heap_.empty()) return first;
    std::size_t at = 0;  // a hole, which goes down to where `last` belongs
    for (std::size_t below = 1; below < heap_.size(); below = 2 * at + 1) {
      if (below + 1 < heap_.size() && is_later(heap_[below], heap_[below + 1])) ++below;
      if (!is_later(last, heap_[below])) break;
      heap_[at] = heap_[below];
      at = below;
    }
    heap_[at] = last;
    return first;
  }

 private:
  static bool is_later(const Event& a, const Event& b) {
    if (a.at_ns != b.at_ns) return a.at_ns > b.at_ns;
    return static_cast<std::int32_t>(a.order - b.order) > 0;  // the counter may wrap
  }

  std::vector<Event> heap_;
  std::uint32_t order_ = 0;
};

}  // namespace roadbalance::test

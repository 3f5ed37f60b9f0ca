#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "common/bus/control_messages.hpp"
#include "hil_tests/fuzz/property.hpp"

namespace roadbalance::fuzz {

/// Acknowledgements of a recorder: nothing durable that its disk did not call durable, and everything
/// rising.
class AckCheck {
 public:
  void durable(std::int32_t node, std::int64_t epoch, std::int64_t sequence) {
    std::int64_t& known = durable_[{node, epoch}];
    known = std::max(known, sequence);
  }

  void take(const Ack& ack) {
    require(decode_ack(encode(ack)).has_value(), "a node accepts every ack");
    require(ack.durable <= ack.received && ack.received <= ack.credit, "durable <= received <= credit");
    const auto durable = durable_.find({ack.node, ack.epoch});
    require(ack.durable <= (durable == durable_.end() ? 0 : durable->second),
            "durable is only what the disk has called durable");
    Ack& before = last_.try_emplace({ack.node, ack.epoch}, Ack{}).first->second;
    require(ack.received >= before.received && ack.durable >= before.durable, "acks never take back");
    if (ack.incarnation == before.incarnation)
      require(ack.number > before.number, "acks of one incarnation are numbered upwards");
    before = ack;
    if (ack.durable > 0) reached_.count();
  }

 private:
  static inline Reached reached_{"an ack of something durable"};
  std::map<std::pair<std::int32_t, std::int64_t>, std::int64_t> durable_;
  std::map<std::pair<std::int32_t, std::int64_t>, Ack> last_;
};

}  // namespace roadbalance::fuzz

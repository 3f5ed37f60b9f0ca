#include "firmware/clock_answer.hpp"

#include <chrono>

#include "common/process/pause.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kTurn{50};  // how long a request to stop may wait
constexpr std::chrono::seconds kFollow{1};

/// Counts what is given in each second.
class Allowance {
 public:
  bool take(MachineTime now) {
    if (now - since_ >= std::chrono::seconds(1)) {
      since_ = now;
      given_ = 0;
    }
    return ++given_ <= kMostAnswers;
  }

 private:
  MachineTime since_{};
  int given_ = 0;
};

}  // namespace

void answer_clock(std::stop_token stop, ClockPlace& place, std::int32_t node, std::int64_t epoch,
                  const FrontEnd& front_end, const std::function<void(const std::string&)>& warn) {
  const auto node_ns = [&](MachineTime time) { return to_ns(front_end.node_time(time)); };
  Allowance allowance;
  MachineTime follow_at = MachineClock::now();
  while (!stop.stop_requested()) {
    if (MachineClock::now() >= follow_at) {
      follow_at = MachineClock::now() + kFollow;
      if (const std::string why = place.follow(); !why.empty()) warn(why);
    }
    if (place.socket() == nullptr) {
      pause(stop, kTurn);
      continue;
    }
    ClockSocket& socket = *place.socket();
    const auto got = socket.receive(kTurn);
    if (!got) continue;
    const auto question = decode_clock_datagram(got->bytes());
    if (!question || question->kind != ClockDatagramKind::kQuestion || question->node != node ||
        question->epoch != epoch || !allowance.take(got->received.time))
      continue;
    ClockDatagram answer = *question;
    answer.kind = ClockDatagramKind::kAnswer;
    answer.received_ns = node_ns(got->received.time);
    answer.received_by_kernel = got->received.by_kernel;
    answer.answered_ns = node_ns(MachineClock::now());
    const auto sent = socket.send(got->from, encode(answer));
    if (!sent || !sent->by_kernel) continue;
    answer.kind = ClockDatagramKind::kFollowUp;
    answer.answered_ns = node_ns(sent->time);
    answer.answered_by_kernel = true;
    static_cast<void>(socket.send(got->from, encode(answer)));  // without it the answer's own stamp has to do
  }
}

}  // namespace roadbalance

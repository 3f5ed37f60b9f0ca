#include <cmath>

#include "common/bus/clock_messages.hpp"
#include "hil_tests/deterministic/world.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kFitEvery = 8;  // exchanges: a second
constexpr std::int64_t kLate_ns = 50'000'000;

// One way through kernel and network: never less than 40 us, sometimes milliseconds, each way on its own.
std::int64_t delay_ns(Random& random) {
  const double tail = -std::log(1 - random.uniform());
  const bool burst = random.chance(0.05);
  return 40'000 + static_cast<std::int64_t>(tail * (burst ? 3e6 : 60e3));
}

}  // namespace

// The four stamps of an exchange that ends now, and once a second what the model makes of them against the
// truth: each fit at its instant, and at that of the next, until which it is used.
void World::exchange_stamps(std::size_t which) {
  Node& node = nodes_[which];
  HostMachine& host = *hosts_.front().machine;
  if (!node.machine->is_up() || !host.runs()) return;
  const std::int32_t number = node.machine->number();
  if (!node.clock) node.clock.emplace(number, node.machine->epoch());
  const std::int64_t back_ns = delay_ns(random_);
  const std::int64_t answer_ns = 5'000 + random_.below(100'000);
  const std::int64_t there_ns = delay_ns(random_);
  const std::int64_t answered = now_ns_ - back_ns;
  const std::int64_t received = answered - answer_ns;
  ++node.exchanges;
  if (network_.exchange(which) && !node.machine->hangs()) {
    const ClockExchange exchange{.node = number,
                                 .epoch = node.machine->epoch(),
                                 .number = node.exchanges,
                                 .asked_ns = received - there_ns,
                                 .received_ns = node.machine->clock_ns(received),
                                 .answered_ns = node.machine->clock_ns(answered),
                                 .heard_ns = now_ns_,
                                 .kernel_stamps = 0};
    (void)node.clock->add(exchange);
    host.record({clock_exchange_channel(number), encode(exchange)});
  } else {
    node.clock->add_unanswered();
  }
  if (node.exchanges % kFitEvery != 0) return;
  const ClockFit fit = node.clock->fit(now_ns_);
  host.record({clock_fit_channel(number), encode(fit)});
  const auto holds = [&](const ClockFit& one) {
    const double since_ns = static_cast<double>(now_ns_ - one.host_ns);
    const double error_ns =
        static_cast<double>(one.node_ns - node.machine->clock_ns(now_ns_)) + since_ns * (1 + one.drift);
    return std::abs(error_ns) * 1e-9 <= one.uncertainty_s;
  };
  if (node.fit && now_ns_ - node.fit->host_ns <= ClockModel::kFitLife_ns + kLate_ns) {
    ++clock_windows_;
    clock_covered_ += node.fit_held && holds(*node.fit) ? 1 : 0;
  }
  node.fit.reset();
  if (!fit.is_known()) return;
  node.fit = fit;
  node.fit_held = holds(fit);
}

}  // namespace roadbalance::test

#include "host/recorder/write.hpp"

#include <ctime>

namespace roadbalance {
namespace {

std::int64_t clock_ns(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

void write_record(RecordKeeper& keeper, In<std::vector<Delivery>> deliveries,
                  Out<std::vector<DurableMark>> durable) {
  std::vector<DurableMark> unsent;  // never waits for the reader, who may be waiting for us
  while (!deliveries.finished()) {
    const auto batch = deliveries.receive_for(keeper.time_left(WallClock::now()));
    keeper.set_clocks(clock_ns(CLOCK_REALTIME) / 1000, clock_ns(CLOCK_MONOTONIC_RAW));
    const WallTime now = WallClock::now();
    if (batch)
      for (const auto& delivery : *batch) keeper.append(delivery, now);
    if (keeper.commit_is_due(now))
      for (const auto& mark : keeper.commit(now)) unsent.push_back(mark);
    if (!unsent.empty() && durable.try_send(unsent)) unsent.clear();
  }
  keeper.close(WallClock::now());
}

}  // namespace roadbalance

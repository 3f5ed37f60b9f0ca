#include "hil_tests/bus_watch.hpp"

#include "common/bus/compensation.hpp"
#include "common/bus/results.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance::test {

using std::chrono::milliseconds;

BusWatch::BusWatch(const std::string& url) : bus_(url) {
  bus_.subscribe("RB_HEARTBEAT_.*", [this](std::string_view, std::span<const std::uint8_t> bytes) {
    if (const auto heartbeat = decode_heartbeat(bytes)) heartbeat_[heartbeat->node] = *heartbeat;
  });
  bus_.subscribe("RB_ACK_.*", [this](std::string_view, std::span<const std::uint8_t> bytes) {
    const auto ack = decode_ack(bytes);
    if (ack && ack->epoch == heartbeat(ack->node).epoch) ack_[ack->node] = *ack;
  });
  bus_.subscribe(kRecorderChannel, [this](std::string_view, std::span<const std::uint8_t> bytes) {
    if (const auto status = decode_recorder_status(bytes)) recorder_ = status;
  });
  bus_.subscribe(kIdentificationChannel,
                 [this](std::string_view channel, std::span<const std::uint8_t> bytes) {
                   if (decode_identification(bytes))
                     results_[{std::string(channel), 0}].assign(bytes.begin(), bytes.end());
                 });
  bus_.subscribe(kBalanceChannel, [this](std::string_view channel, std::span<const std::uint8_t> bytes) {
    if (const auto balance = decode_balance(bytes))
      results_[{std::string(channel), balance->wheel}].assign(bytes.begin(), bytes.end());
  });
  bus_.subscribe(kCompensationChannel, [this](std::string_view channel, std::span<const std::uint8_t> bytes) {
    if (const auto compensation = decode_compensation(bytes))
      results_[{std::string(channel), compensation->wheel}].assign(bytes.begin(), bytes.end());
  });
  bus_.handle(milliseconds(0));  // from here on samples take no room, however long this does not listen
}

bool BusWatch::wait(const std::function<bool()>& condition, double seconds) {
  const auto deadline = WallClock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (WallClock::now() > deadline) return false;
    bus_.handle(milliseconds(2));
  }
  return true;
}

void BusWatch::listen(double seconds) {
  wait([] { return false; }, seconds);
}

Heartbeat BusWatch::heartbeat(std::int32_t node) const {
  const auto found = heartbeat_.find(node);
  return found == heartbeat_.end() ? Heartbeat{} : found->second;
}

Ack BusWatch::ack(std::int32_t node) const {
  const auto found = ack_.find(node);
  return found == ack_.end() ? Ack{} : found->second;
}

}  // namespace roadbalance::test

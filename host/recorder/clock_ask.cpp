#include "host/recorder/clock_ask.hpp"

#include <chrono>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "host/recorder/event_outlet.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kTurn{10};     // longest wait for an answer: bounds how late a question is sent
constexpr int kAnswersPerTurn = 256;  // a flood must not keep questions from being sent

}  // namespace

void ask_clocks(const std::string& bus_url, In<ClockPeer> peers, Out<RecordEvent> events) {
  Bus bus(bus_url);
  ClockSocket socket(0);
  ClockAsker asker;
  EventOutlet record(std::move(events));
  while (!peers.finished()) {
    while (const auto peer = peers.receive_for(milliseconds(0))) asker.heard(*peer, MachineClock::now());
    for (const auto& question : asker.due(MachineClock::now()))
      if (const auto stamp = socket.send(question.to, encode(question.datagram)))
        asker.sent(question, *stamp);
    auto wait = kTurn;
    for (int i = 0; i < kAnswersPerTurn; ++i, wait = milliseconds(0)) {
      const auto got = socket.receive(wait);
      if (!got) break;
      if (const auto datagram = decode_clock_datagram(got->bytes()))
        asker.take(*datagram, got->from, got->received);
    }
    const MachineTime now = MachineClock::now();
    for (const auto& exchange : asker.exchanges(now))
      record.put({clock_exchange_channel(exchange.node), encode(exchange)});
    for (const auto& fit : asker.fits(now)) {
      auto bytes = encode(fit);
      bus.publish(clock_fit_channel(fit.node), bytes);  // for displays; nobody misses one
      record.put({clock_fit_channel(fit.node), std::move(bytes)});
    }
  }
}

}  // namespace roadbalance

#include "host/recorder/clock_asker.hpp"

#include <algorithm>
#include <chrono>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "host/recorder/event_outlet.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
constexpr std::int64_t kBurst = 16;
constexpr milliseconds kBurstPeriod{20};
constexpr milliseconds kPeriod{125};
constexpr milliseconds kFollowUp{50};
constexpr seconds kGiveUp{1};
constexpr seconds kClockSilence{10};
constexpr std::chrono::nanoseconds kFitPeriod{ClockModel::kFitLife_ns};
constexpr std::size_t kMostOpen = 32;
constexpr milliseconds kAnswerWait{10};  // longest wait for an answer: bounds how late a question is sent
constexpr int kAnswersPerTurn = 256;     // a flood must not keep questions from being sent

}  // namespace

void ClockAsker::heard(const ClockPeer& peer, MachineTime now) {
  const std::pair key{peer.node, peer.epoch};
  auto found = clocks_.find(key);
  if (found == clocks_.end()) {
    if (clocks_.size() >= 2 * kMostNodes && !forget_one(now)) return;
    found = clocks_
                .emplace(key, Clock{.address = peer.address,
                                    .model = ClockModel(peer.node, peer.epoch),
                                    .heard_at = now,
                                    .ask_at = now,
                                    .burst_ends = kBurst,
                                    .open = {},
                                    .fit_at = now})
                .first;
  }
  Clock& clock = found->second;
  if (is_silent(clock, now)) clock.burst_ends = clock.asked + kBurst;
  clock.address = peer.address;
  clock.heard_at = now;
}

bool ClockAsker::is_silent(const Clock& clock, MachineTime now) {
  return now - clock.heard_at > kClockSilence;
}

bool ClockAsker::forget_one(MachineTime now) {
  const auto longest =
      std::ranges::min_element(clocks_, {}, [](const auto& clock) { return clock.second.heard_at; });
  if (longest == clocks_.end() || !is_silent(longest->second, now)) return false;
  clocks_.erase(longest);
  return true;
}

std::vector<ClockAsker::Question> ClockAsker::due(MachineTime now) {
  std::vector<Question> questions;
  for (auto& [key, clock] : clocks_) {
    while (!clock.open.empty() &&
           (now - clock.open.front().sent.time > kGiveUp || clock.open.size() >= kMostOpen)) {
      clock.model.add_unanswered();
      clock.open.pop_front();
    }
    if (now < clock.ask_at || clock.address.address == 0 || is_silent(clock, now)) continue;
    const std::int64_t number = ++clock.asked;
    clock.ask_at = now + (number < clock.burst_ends ? kBurstPeriod : kPeriod);
    questions.push_back({{.node = key.first, .epoch = key.second, .number = number}, clock.address});
  }
  return questions;
}

void ClockAsker::host_slept() {
  for (auto& [key, clock] : clocks_) {
    clock.open.clear();  // an answer to one of before would be late by the sleep
    clock.model.host_stepped();
    clock.burst_ends = clock.asked + kBurst;
  }
}

void ClockAsker::sent(const Question& question, const Stamp& stamp) {
  const auto clock = clocks_.find({question.datagram.node, question.datagram.epoch});
  if (clock != clocks_.end())
    clock->second.open.push_back({question.datagram.number, stamp, std::nullopt, {}});
}

void ClockAsker::take(const ClockDatagram& datagram, const UdpAddress& from, const Stamp& heard) {
  const auto found = clocks_.find({datagram.node, datagram.epoch});
  if (found == clocks_.end() || from != found->second.address) return;
  Clock& clock = found->second;
  const auto asked = std::find_if(clock.open.begin(), clock.open.end(),
                                  [&](const Asked& a) { return a.number == datagram.number; });
  if (asked == clock.open.end()) return;
  if (datagram.kind == ClockDatagramKind::kAnswer && !asked->answer) {
    asked->answer = datagram;
    asked->heard = heard;
  } else if (datagram.kind == ClockDatagramKind::kFollowUp && asked->answer &&
             datagram.received_ns == asked->answer->received_ns) {
    asked->answer = datagram;
    complete(clock, *asked, datagram.node, datagram.epoch);
    clock.open.erase(asked);
  }
}

void ClockAsker::complete(Clock& clock, const Asked& asked, std::int32_t node, std::int64_t epoch) {
  const ClockDatagram& answer = *asked.answer;
  const auto bit = [](bool set, int k) { return set ? 1U << k : 0U; };
  const ClockExchange exchange{
      .node = node,
      .epoch = epoch,
      .number = asked.number,
      .asked_ns = to_ns(asked.sent.time),
      .received_ns = answer.received_ns,
      .answered_ns = answer.answered_ns,
      .heard_ns = to_ns(asked.heard.time),
      .kernel_stamps = bit(asked.sent.by_kernel, 0) | bit(answer.received_by_kernel, 1) |
                       bit(answer.answered_by_kernel, 2) | bit(asked.heard.by_kernel, 3)};
  clock.model.add(exchange);
  complete_.push_back(exchange);
}

std::vector<ClockExchange> ClockAsker::exchanges(MachineTime now) {
  for (auto& [key, clock] : clocks_) {
    const auto without_follow_up = [&](const Asked& asked) {
      return asked.answer && now - asked.heard.time > kFollowUp;
    };
    for (const Asked& asked : clock.open)
      if (without_follow_up(asked)) complete(clock, asked, key.first, key.second);
    std::erase_if(clock.open, without_follow_up);
  }
  return std::exchange(complete_, {});
}

std::vector<ClockFit> ClockAsker::fits(MachineTime now) {
  std::vector<ClockFit> fits;
  for (auto& [key, clock] : clocks_) {
    const bool locks = clock.state == ClockState::kAcquire && clock.model.is_locked();
    if (is_silent(clock, now) || (now < clock.fit_at && !locks && clock.model.breaks() == clock.breaks))
      continue;
    fits.push_back(clock.model.fit(to_ns(now)));
    clock.state = fits.back().state;
    clock.breaks = fits.back().breaks;
    clock.fit_at = now + kFitPeriod;
  }
  return fits;
}

void ask_clocks(const std::string& bus_url, In<ClockPeer> peers, Out<RecordEvent> events) {
  Bus bus(bus_url);
  ClockSocket socket(0);
  ClockAsker asker;
  EventOutlet record(std::move(events));
  MachineClock::duration slept = MachineClock::slept();
  while (!peers.finished()) {
    const MachineClock::duration before = std::exchange(slept, MachineClock::slept());
    if (slept != before) asker.host_slept();
    while (const auto peer = peers.receive_for(milliseconds(0))) asker.heard(*peer, MachineClock::now());
    for (const auto& question : asker.due(MachineClock::now()))
      if (const auto stamp = socket.send(question.to, encode(question.datagram)))
        asker.sent(question, *stamp);
    auto wait = kAnswerWait;
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
      bus.publish(clock_fit_channel(fit.node), bytes);  // for displays, which do without one
      record.put({clock_fit_channel(fit.node), std::move(bytes)});
    }
  }
}

}  // namespace roadbalance

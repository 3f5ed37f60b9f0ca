#include "hil_tests/deterministic/world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/bus/clock_messages.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kTurn_ns = 2'000'000;  // the link processes look around so often when nothing comes
constexpr std::int64_t kBusyTurn_ns = 100'000;
constexpr std::int64_t kWake_ns = 50'000;   // from a datagram to the turn it causes
constexpr std::size_t kSocketHolds = 2000;  // datagrams of a process that does not read
constexpr std::int64_t kCheck_ns = 5 * kSecond_ns;
constexpr std::int64_t kLongestDrain_ns = 90 * kSecond_ns;

std::int64_t to_ns(double seconds) {
  return static_cast<std::int64_t>(seconds * 1e9);
}

}  // namespace

World::World(const FaultScenario& scenario, std::uint64_t seed, double seconds)
    : scenario_(scenario),
      production_ns_(to_ns(seconds)),
      random_(seed, 0),
      network_(scenario, random_.bits(), events_) {
  for (int n = 0; n < scenario.nodes; ++n) {
    const std::int32_t number = scenario.same_ids ? 1 : n + 1;
    Node& node = nodes_.emplace_back();
    node.machine = std::make_unique<NodeMachine>(scenario, number, random_.bits(), truth_);
    network_.add_node(number);
  }
  for (int h = 0; h < scenario.hosts; ++h) {
    Host& host = hosts_.emplace_back();
    host.machine = std::make_unique<HostMachine>(scenario, h + 1, random_.bits(), truth_);
  }
  if (scenario.is_operated())
    for (std::int64_t number : {1, 2}) askers_.emplace_back(number, random_.bits(), truth_);
  std::int64_t last_ns = production_ns_;
  faults_.reserve(1024);
  for (const PlannedFault& fault : scenario.faults) plan(fault, last_ns);
  events_.add(last_ns + kSecond_ns / 2, Event::Kind::kStop, 0);
}

World::~World() = default;

// Evenly spread, and one over before the next where there is time for both: a hundred kills are a hundred.
void World::plan(const PlannedFault& fault, std::int64_t& last_ns) {
  const double share = static_cast<double>(production_ns_) * 1e-9 / scenario_.seconds;
  const auto times = static_cast<std::int64_t>(std::ceil(fault.times * share - 1e-9));
  const double from_ns = fault.from * static_cast<double>(production_ns_);
  const double slot_ns =
      (fault.to - fault.from) * static_cast<double>(production_ns_) / static_cast<double>(times);
  const double longest_ns = fault.lasting.longest_s * 1e9;
  const double room_ns = slot_ns > longest_ns ? slot_ns - longest_ns : slot_ns;
  const bool of_host = fault.kind == FaultKind::kKillRecorder || fault.kind == FaultKind::kPauseRecorder ||
                       fault.kind == FaultKind::kPowerCut || fault.kind == FaultKind::kDiskFull ||
                       fault.kind == FaultKind::kDiskFailing || fault.kind == FaultKind::kWallStep;
  for (std::int64_t k = 0; k < times; ++k) {
    const auto on =
        static_cast<std::int64_t>(from_ns + slot_ns * static_cast<double>(k) + room_ns * random_.uniform());
    const std::int64_t off = on + to_ns(random_.between(fault.lasting.shortest_s, fault.lasting.longest_s));
    const auto targets = static_cast<std::int64_t>(of_host ? hosts_.size() : nodes_.size());
    faults_.push_back({&fault, static_cast<std::size_t>(random_.below(targets)), random_.uniform()});
    if (fault.kind == FaultKind::kLateNode) {
      Node& late = nodes_[faults_.back().target];
      late.down += 1;
      const std::int64_t comes = off - on;
      late.left = late.left || comes >= production_ns_;  // it never comes
      if (!late.left) events_.add(comes, Event::Kind::kFaultOff, 0, faults_.size() - 1);
      continue;
    }
    events_.add(on, Event::Kind::kFaultOn, 0, faults_.size() - 1);
    events_.add(off, Event::Kind::kFaultOff, 0, faults_.size() - 1);
    last_ns = std::max(last_ns, off);
  }
}

void World::boot_node(std::size_t which) {
  Node& node = nodes_[which];
  if (node.down > 0 || node.machine->is_up()) return;
  node.machine->boot(now_ns_);
  node.cleared_behind = 0;
  node.clock.reset();
  node.fit.reset();
  wake_node(which, now_ns_ + kTurn_ns);
}

void World::boot_host(std::size_t which) {
  Host& host = hosts_[which];
  if (host.down > 0 || host.machine->is_up() || host.machine->closed()) return;
  // A recorder that has just begun has no clock.
  if (which == 0)
    for (Node& node : nodes_) node.clock.reset(), node.fit.reset();
  if (host.machine->boot(now_ns_))
    wake_host(which, now_ns_ + host.machine->take_elapsed_ns() + kTurn_ns);
  else
    events_.add(now_ns_ + kSecond_ns / 2, Event::Kind::kHostTurn, which, 1);
}

void World::wake_node(std::size_t which, std::int64_t at_ns) {
  Node& node = nodes_[which];
  if (node.turn_at_ns > now_ns_ && node.turn_at_ns <= at_ns) return;
  node.turn_at_ns = at_ns;
  events_.add(at_ns, Event::Kind::kNodeTurn, which);
}

void World::wake_host(std::size_t which, std::int64_t at_ns) {
  Host& host = hosts_[which];
  if (host.turn_at_ns > now_ns_ && host.turn_at_ns <= at_ns) return;
  host.turn_at_ns = at_ns;
  events_.add(at_ns, Event::Kind::kHostTurn, which);
}

void World::turn_node(std::size_t which) {
  Node& node = nodes_[which];
  if (node.turn_at_ns != now_ns_ || node.machine->hangs()) return;
  const Publish publish = [&](const std::string& channel, std::span<const std::uint8_t> bytes) {
    network_.from_node(which, channel, bytes, now_ns_);
    return true;
  };
  const bool busy = node.machine->turn(now_ns_, publish);
  watch_pull(node);
  if (node.machine->finished() && scenario_.is_operated()) {
    node.machine->begin_anew(now_ns_, publish);
    node.cleared_behind = 0;
  } else if (node.machine->finished()) {
    node.machine->leave(publish);
    node.left = !std::exchange(node.ends, false);
    if (!node.left) boot_node(which);
    return;
  }
  wake_node(which, now_ns_ + (busy ? kBusyTurn_ns : kTurn_ns));
}

void World::turn_host(std::size_t which) {
  Host& host = hosts_[which];
  if (!host.machine->is_up()) return;
  if (host.turn_at_ns != now_ns_ || !host.machine->runs()) return;
  host.machine->turn(now_ns_, [&](const std::string& channel, std::span<const std::uint8_t> bytes) {
    network_.from_host(which, channel, bytes, now_ns_);
    return true;
  });
  if (host.machine->is_up()) wake_host(which, now_ns_ + kTurn_ns);
}

void World::arrive_at_node(const Event& event) {
  Node& node = nodes_[event.who];
  DatagramPool& datagrams = network_.datagrams();
  if (node.machine->is_up() && node.machine->hangs() && node.socket.size() < kSocketHolds) {
    node.socket.push_back(event.what);
    return;
  }
  if (!node.machine->hangs()) {
    node.machine->take(datagrams.channel(event.what), datagrams.bytes(event.what), now_ns_);
    wake_node(event.who, now_ns_ + kWake_ns);
  }
  datagrams.release(event.what);
}

void World::arrive_at_host(const Event& event) {
  Host& host = hosts_[event.who];
  DatagramPool& datagrams = network_.datagrams();
  if (host.machine->is_up() && !host.machine->runs() && host.socket.size() < kSocketHolds) {
    host.socket.push_back(event.what);
    return;
  }
  if (host.machine->runs()) {
    host.machine->take(datagrams.channel(event.what), datagrams.bytes(event.what), now_ns_);
    wake_host(event.who, now_ns_ + kWake_ns);
  }
  datagrams.release(event.what);
}

// Messages in the socket of a process that slept, or that went away with it.
void World::drain_sockets() {
  DatagramPool& datagrams = network_.datagrams();
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    Node& node = nodes_[n];
    if (node.socket.empty() || (node.machine->is_up() && node.machine->hangs())) continue;
    for (const std::uint32_t datagram : node.socket) {
      node.machine->take(datagrams.channel(datagram), datagrams.bytes(datagram), now_ns_);
      datagrams.release(datagram);
    }
    node.socket.clear();
    wake_node(n, now_ns_ + kWake_ns);
  }
  for (std::size_t h = 0; h < hosts_.size(); ++h) {
    Host& host = hosts_[h];
    if (host.socket.empty() || (host.machine->is_up() && !host.machine->runs())) continue;
    for (const std::uint32_t datagram : host.socket) {
      host.machine->take(datagrams.channel(datagram), datagrams.bytes(datagram), now_ns_);
      datagrams.release(datagram);
    }
    host.socket.clear();
    wake_host(h, now_ns_ + kWake_ns);
  }
}

// How long after the cable is back until all that was sealed before is given back.
void World::watch_pull(Node& node) {
  if (node.cleared_behind == 0 || node.machine->base() <= node.cleared_behind) return;
  node.cleared_behind = 0;
  longest_pull_cleared_s_ =
      std::max(longest_pull_cleared_s_, static_cast<double>(now_ns_ - node.plugged_at_ns) * 1e-9);
}

void World::handle(const Event& event) {
  switch (event.kind) {
    case Event::Kind::kDevice: {
      if (nodes_[event.who].left) return;
      return events_.add(nodes_[event.who].machine->device(now_ns_), Event::Kind::kDevice, event.who);
    }
    case Event::Kind::kNodeTurn:
      return turn_node(event.who);
    case Event::Kind::kHostTurn:
      return event.what == 1 ? boot_host(event.who) : turn_host(event.who);
    case Event::Kind::kToNode:
      return arrive_at_node(event);
    case Event::Kind::kToHost:
      return arrive_at_host(event);
    case Event::Kind::kFaultOn:
    case Event::Kind::kFaultOff:
      turn_fault(faults_[event.what], event.kind == Event::Kind::kFaultOn);
      return drain_sockets();
    case Event::Kind::kClock:
      exchange_stamps(event.who);
      return events_.add(now_ns_ + kSecond_ns / 8, Event::Kind::kClock, event.who);
    case Event::Kind::kCheck:
      check_finished();
      return events_.add(now_ns_ + kCheck_ns, Event::Kind::kCheck, 0);
    case Event::Kind::kAsker:
      return turn_asker(event.who);
    case Event::Kind::kToAskers:
      return take_answer(event);
    case Event::Kind::kStop:
      stopped_ = true;
      stopped_ns_ = now_ns_;
      if (!scenario_.is_operated())
        for (Host& host : hosts_) host.machine->stop();
      return;
  }
}

bool World::is_over() const {
  return std::all_of(hosts_.begin(), hosts_.end(), [](const Host& host) { return host.machine->closed(); }) &&
         (scenario_.is_operated() ||
          std::all_of(nodes_.begin(), nodes_.end(), [](const Node& node) { return node.left; }));
}

RunResult World::run() {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    now_ns_ = random_.below(kSecond_ns / 2);
    boot_node(n);
    events_.add(now_ns_, Event::Kind::kDevice, n);
    if (scenario_.clocks) events_.add(now_ns_, Event::Kind::kClock, n);
  }
  for (std::size_t h = 0; h < hosts_.size(); ++h) {
    const std::int64_t at_ns =
        h == 0 ? random_.below(kSecond_ns / 2)
               : static_cast<std::int64_t>(scenario_.second_starts * static_cast<double>(production_ns_));
    events_.add(at_ns, Event::Kind::kHostTurn, h, 1);
  }
  for (std::size_t k = 0; k < askers_.size(); ++k) events_.add(kSecond_ns, Event::Kind::kAsker, k);
  events_.add(kCheck_ns, Event::Kind::kCheck, 0);
  std::int64_t stopped_ns = 0;
  while (!events_.empty() && !(stopped_ && is_over())) {
    const Event event = events_.take();
    now_ns_ = event.at_ns;
    truth_.set_now(now_ns_);
    handle(event);
    if (!stopped_) stopped_ns = now_ns_;
    if (now_ns_ - stopped_ns > (scenario_.is_operated() ? 3 : 1) * kLongestDrain_ns) {
      fault_not_over(now_ns_ - stopped_ns);
      break;
    }
  }
  return result();
}

namespace {

constexpr std::int64_t kLook_ns = 20'000'000;
// Blocks that nodes hold without the recorder knowing are found while nothing is recorded.
constexpr std::int64_t kQuiet_ns = 5'000'000'000;

/// It reports that this node may measure by another vehicle.toml.
bool names(const Answer& answer, std::int32_t node) {
  const std::string number = std::to_string(node);
  if (answer.text.find("node " + number + " may keep the new set-up") != std::string::npos) return true;
  const std::string absent = "not on the bus: node ";
  const auto at = answer.text.find(absent);
  return at != std::string::npos && answer.text.find(number, at + absent.size()) != std::string::npos;
}

}  // namespace

void World::turn_asker(std::size_t which) {
  HostMachine& host = *hosts_.front().machine;
  const bool records = host.is_up() && host.has_work();
  if (const auto request =
          askers_[which].turn(now_ns_, stopped_, which == 0 && records, host.unsure_deaths()))
    network_.from_asker(kRequestChannel, encode(*request), now_ns_);
  if (records || !host.is_up()) quiet_since_ns_ = now_ns_;
  if (stopped_ && now_ns_ - quiet_since_ns_ >= kQuiet_ns &&
      std::ranges::none_of(askers_, [](const Asker& asker) { return asker.waits(); }))
    host.stop();
  if (!host.closed()) events_.add(now_ns_ + kLook_ns, Event::Kind::kAsker, which);
}

void World::take_answer(const Event& event) {
  if (const auto answer = decode_answer(network_.datagrams().bytes(event.what)))
    for (Asker& asker : askers_) asker.take(*answer, hosts_.front().machine->unsure_deaths());
  network_.datagrams().release(event.what);
}

bool World::was_named(std::int32_t node) const {
  return std::ranges::any_of(askers_, [&](const Asker& asker) {
    return std::ranges::any_of(
        asker.asked(), [&](const Asker::Asked& asked) { return asked.answer && names(*asked.answer, node); });
  });
}

// All nodes measure by the file that the recorder leads, but for those that it names.
void World::check_set_up() {
  if (!scenario_.is_operated()) return;
  const std::uint32_t file = hosts_.front().machine->vehicle_crc32c();
  for (const Node& node : nodes_)
    if (const auto crc = node.machine->changed_vehicle();
        crc && *crc != file && !was_named(node.machine->number()))
      truth_.fault("node " + std::to_string(node.machine->number()) +
                   " measures by another vehicle.toml than the recorder's, and nobody was told");
}

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

namespace {

constexpr double kDay_us = 86'400e6;

}  // namespace

void World::turn_fault(const Timed& timed, bool on) {
  switch (timed.fault->kind) {
    case FaultKind::kPull:
    case FaultKind::kKillNode:
    case FaultKind::kPauseNode:
    case FaultKind::kHangUplink:
    case FaultKind::kSpoolFailing:
    case FaultKind::kEndNode:
    case FaultKind::kLateNode:
    case FaultKind::kSuspendNode:
      if (timed.fault->kind != FaultKind::kPull || !timed.fault->all_nodes)
        return turn_node_fault(timed, timed.target, on);
      for (std::size_t node = 0; node < nodes_.size(); ++node) turn_node_fault(timed, node, on);
      return;
    case FaultKind::kKillRecorder:
    case FaultKind::kPauseRecorder:
    case FaultKind::kPowerCut:
    case FaultKind::kDiskFull:
    case FaultKind::kDiskFailing:
    case FaultKind::kWallStep:
      return turn_host_fault(timed, on);
  }
}

void World::turn_node_fault(const Timed& timed, std::size_t which, bool on) {
  Node& node = nodes_[which];
  switch (timed.fault->kind) {
    case FaultKind::kPull:
      network_.pull(which, timed.fault->direction, on);
      node.cleared_behind = on ? 0 : node.machine->next() - 1;
      node.plugged_at_ns = now_ns_;
      return;
    case FaultKind::kKillNode:
      node.down += on ? 1 : -1;
      if (on) node.machine->kill(timed.chance < 0.5), node.ends = false;
      if (!on) boot_node(which);
      return;
    case FaultKind::kEndNode:
      return end_node(timed, node, on);
    case FaultKind::kLateNode:
      node.down -= 1;
      return boot_node(which);
    case FaultKind::kPauseNode:
      node.machine->pause(on);
      if (!on) wake_node(which, now_ns_ + 1);
      return;
    case FaultKind::kSuspendNode:
      node.machine->suspend(on, now_ns_);
      if (!on) wake_node(which, now_ns_ + 1);
      return;
    case FaultKind::kHangUplink:
      node.machine->hang(on);
      if (!on) wake_node(which, now_ns_ + 1);
      return;
    case FaultKind::kSpoolFailing:
      return node.machine->fail_spool(on ? timed.fault->strength : 0);
    default:
      return;
  }
}

void World::end_node(const Timed& timed, Node& node, bool on) {
  node.down += on ? 1 : -1;
  if (!on) return boot_node(timed.target);
  if (!node.machine->runs()) return;
  constexpr std::array kCauses{AbsenceCause::kProgramEnded, AbsenceCause::kStopped,
                               AbsenceCause::kDeviceFailed};
  node.ends = true;
  node.machine->end(kCauses[static_cast<std::size_t>(timed.chance * 2.999)]);
}

// Two of three in the middle of what the recorder does next with its disk.
void World::turn_death(const Timed& timed, Host& host, bool on) {
  const bool power = timed.fault->kind == FaultKind::kPowerCut;
  const int call = static_cast<int>(timed.chance * 36);
  host.down += on ? 1 : -1;
  if (on && host.machine->boots() > 0) ++kills_;
  if (on && call < 24 && host.down == 1)
    return host.machine->die_at_call(power, call < 12 ? call + 1 : (call - 12) / 4 + 1, call >= 12);
  if (host.machine->is_up()) power ? host.machine->cut_power() : host.machine->kill();
  if (!on) boot_host(timed.target);
}

void World::turn_host_fault(const Timed& timed, bool on) {
  Host& host = hosts_[timed.target];
  switch (timed.fault->kind) {
    case FaultKind::kKillRecorder:
    case FaultKind::kPowerCut:
      return turn_death(timed, host, on);
    case FaultKind::kPauseRecorder:
      host.machine->pause(on);
      if (!on && host.machine->is_up()) wake_host(timed.target, now_ns_ + 1);
      return;
    case FaultKind::kDiskFull:
      return host.machine->fill_disk(on);
    case FaultKind::kDiskFailing:
      return host.machine->fail_disk(on ? timed.fault->strength : 0);
    case FaultKind::kWallStep:
      if (on) host.machine->step_wall_clock(static_cast<std::int64_t>((2 * timed.chance - 1) * kDay_us));
      return;
    default:
      return;
  }
}

// The truth of what every record has shown to have is needed no more.
void World::check_finished() {
  for (Host& host : hosts_) host.machine->check_finished();
  if (hosts_.size() > 1) return;
  truth_.drop_checked([this](std::int32_t node, std::int64_t epoch) {
    return hosts_.front().machine->check().checked(node, epoch);
  });
}

namespace {

/// Shorter silences may go unnoticed where no epoch shows them.
constexpr std::int64_t kSurely_ns = 4 * kSecond_ns;
constexpr std::int64_t kMoment_ns = kSecond_ns;
constexpr double kNear_s = 1.5;  // lost heartbeats, and the time to be claimed and started

struct TrueAbsence {
  std::int64_t from_ns = 0, to_ns = 0;
  AbsenceCause cause = AbsenceCause::kNeverCame;
  bool to_end = false;
};

std::vector<TrueAbsence> true_absences(const Truth& truth, std::int32_t node, std::int64_t begin_ns,
                                       std::int64_t stop_ns) {
  std::vector<TrueAbsence> all;
  TrueAbsence now{.from_ns = begin_ns};
  for (const Truth::Measured& one : truth.measured()) {
    if (one.node != node) continue;
    now.to_ns = one.from_ns;
    all.push_back(now);
    now = {.from_ns = one.to_ns, .cause = one.end};
    if (one.to_ns == 0 || one.to_ns >= stop_ns) return all;
  }
  now.to_ns = stop_ns;
  now.to_end = true;
  all.push_back(now);
  return all;
}

// A node tells its end in each of its heartbeats, of which several in a row are not lost; and that it never
// came is known in the end, however short the recording was.
bool is_surely_noticed(const TrueAbsence& is) {
  const std::int64_t lasts_ns = is.to_ns - is.from_ns;
  if (!is.to_end || is.cause == AbsenceCause::kSilent) return lasts_ns >= kSurely_ns;
  return is.cause == AbsenceCause::kNeverCame || lasts_ns >= kMoment_ns;
}

bool are_one(const TrueAbsence& is, const Absence& said, std::int64_t said_ns) {
  const double from_s = 1e-9 * static_cast<double>(is.from_ns - said_ns);
  const double lasts_s = 1e-9 * static_cast<double>(is.to_ns - is.from_ns) - said.seconds;
  return is.cause == said.cause && is.to_end == said.to_end && std::abs(from_s) < kNear_s &&
         std::abs(lasts_s) < kNear_s;
}

}  // namespace

// Each absence is in the record, at its time and with its cause, and none that was none.
void World::check_absences() {
  HostMachine& host = *hosts_.front().machine;
  std::vector<Absence> said = host.absences();
  bool is_any = false;
  for (std::int32_t node = 1; node <= scenario_.nodes; ++node) {
    const auto find = [&](const TrueAbsence& is) {
      return std::ranges::find_if(said, [&](const Absence& one) {
        return one.node == node && are_one(is, one, host.ns_of(one.since_us));
      });
    };
    const std::vector<TrueAbsence> all = true_absences(truth_, node, host.began_ns(), stopped_ns_);
    for (std::size_t k = 0; k < all.size(); ++k) {
      TrueAbsence is = all[k];
      auto found = find(is);
      // Nobody needs to have heard a node that measured for a moment between two.
      if (found == said.end() && k + 1 < all.size() && all[k + 1].from_ns - is.to_ns < kMoment_ns) {
        is.to_ns = all[k + 1].to_ns;
        is.to_end = all[++k].to_end;
        found = find(is);
      }
      const bool surely = is_surely_noticed(is);
      is_any = is_any || surely;
      if (found == said.end() && surely)
        truth_.fault("node " + std::to_string(node) + " was absent from " +
                     std::to_string(1e-9 * static_cast<double>(is.from_ns)) + " s to " +
                     std::to_string(1e-9 * static_cast<double>(is.to_ns)) + " s (cause " +
                     std::to_string(static_cast<int>(is.cause)) + "), and its record does not say so");
      if (found != said.end()) said.erase(found);
    }
  }
  for (const Absence& one : said)
    truth_.fault("the record says that node " + std::to_string(one.node) + " " + words(one) + ", from " +
                 std::to_string(1e-9 * static_cast<double>(host.ns_of(one.since_us))) +
                 " s, which is not so");
  if (is_any && host.is_called_complete())
    truth_.fault("a record is called complete though a node was absent");
}

void World::fault_not_over(std::int64_t waited_ns) {
  const std::string over = "the drive is over for " + std::to_string(waited_ns / 1'000'000'000) + " s and ";
  for (const Host& host : hosts_)
    if (!host.machine->closed()) truth_.fault(over + "a recorder has not ended");
  for (const Node& node : nodes_)
    if (!node.left && !scenario_.is_operated())
      truth_.fault(over + "node " + std::to_string(node.machine->number()) + " holds " +
                   std::to_string(node.machine->used()) + " blocks or has not ended");
}

RunResult World::result() {
  RunResult result;
  check_set_up();
  for (Host& host : hosts_) {
    RecordCheck& check = host.machine->check();
    host.machine->kill();
    host.machine->check_record();
    for (const Asker& asker : askers_) host.machine->check_asked(asker.asked());
    check.finish(host.machine->closed() && hosts_.size() == 1);
    if (scenario_.expect.absences) check_absences();
    result.recorded += check.blocks();
    result.lost_scans += check.lost_scans();
    result.declared_scans += check.declared_scans();
    result.declared_gaps += check.declared_gaps();
    result.tail_scans += check.crash_tail_scans();
    result.longest_to_durable_s = std::max(result.longest_to_durable_s, host.machine->longest_to_durable_s());
    result.fallbacks += host.machine->fell_back() ? 1 : 0;
    result.disk_fulls += host.machine->disk_fulls();
    result.clock_events += host.machine->clock_events().found();
    result.recorder_boots += host.machine->boots();
    result.deaths_at_call += host.machine->deaths_at_call();
  }
  for (const auto& [key, epoch] : truth_.epochs()) {
    result.scans += epoch.scans;
    ++result.node_boots;
    // The last owner of several recorders has it; each one's promises were checked in its own record.
    const bool has_end = std::any_of(hosts_.begin(), hosts_.end(), [&](const Host& host) {
      return host.machine->check().is_closed(epoch.node, epoch.epoch);
    });
    if (hosts_.size() > 1 && epoch.scans > 0 && !has_end)
      truth_.fault("node " + std::to_string(epoch.node) + ": no recorder has the end of its epoch");
  }
  const std::int64_t deaths = result.recorder_boots - static_cast<std::int64_t>(hosts_.size());
  if (scenario_.expect.dies_each_time && deaths != kills_)
    truth_.fault("recorders died " + std::to_string(deaths) + " times, killed " + std::to_string(kills_) +
                 " times");
  result.clock_windows = clock_windows_;
  result.clock_covered = clock_covered_;
  result.bus_s = static_cast<double>(now_ns_) * 1e-9;
  result.blocks = truth_.blocks_sealed();
  result.lost_edges = truth_.lost_edges();
  result.late_starts = truth_.late_starts();
  result.lost_signals = truth_.lost_signals();
  result.sent = network_.blocks_sent();
  result.longest_pull_cleared_s = longest_pull_cleared_s_;
  // A start that the network loses again and again begins late.
  const bool may_be_late = scenario_.loss_to_host > 0 || scenario_.loss_to_node > 0;
  if (scenario_.expect.complete &&
      (result.declared_gaps + result.tail_scans > 0 || (!may_be_late && result.declared_scans > 0)))
    truth_.fault(std::to_string(result.declared_gaps) + " gaps with " +
                 std::to_string(result.declared_scans + result.tail_scans) +
                 " scans are declared where all must be there");
  if (scenario_.expect.complete && result.lost_edges + result.lost_signals > 0)
    truth_.fault(std::to_string(result.lost_edges) + " edges and " + std::to_string(result.lost_signals) +
                 " signals are lost where all must be there");
  result.faults = truth_.fault_count();
  std::string what;
  for (const std::string& fault : truth_.faults()) what += fault + "\n";
  std::strncpy(result.what.data(), what.c_str(), result.what.size() - 1);
  return result;
}

namespace {

void write_file(const std::filesystem::path& path, const char* bytes, std::size_t size) {
  std::ofstream stream(path, std::ios::binary);
  stream.write(bytes, static_cast<std::streamsize>(size));
  stream.close();
  if (!stream) throw std::runtime_error("cannot write " + path.string());
}

// Messages and acts of an epoch's nodes and recorders, for tools/record_check/truth.py to judge.
nlohmann::json deeds_of(const EpochTruth& epoch, const RecordCheck::Said& said) {
  nlohmann::json declared = nlohmann::json::array();
  for (const auto& [sequence, then] : said.declared)
    declared.push_back({{"sequence", sequence},
                        {"promised", then.promised},
                        {"released", then.released},
                        {"may_lack_more", then.may_lack_more}});
  return {{"node", epoch.node},    {"epoch", epoch.epoch},      {"openings", epoch.openings},
          {"scans", epoch.scans},  {"promised", said.promised}, {"declared", declared},
          {"obeyed", epoch.obeyed}};
}

// Only that one of several recorders that saw the end of an epoch must have it.
std::string truth_of(const Truth& truth, const RecordCheck& check, bool only_recorder) {
  nlohmann::json epochs = nlohmann::json::array();
  for (const auto& [key, epoch] : truth.epochs()) {
    const bool must_end = only_recorder || check.is_closed(epoch.node, epoch.epoch);
    const RecordCheck::Said* said = check.said(epoch.node, epoch.epoch);
    epochs.push_back(deeds_of(epoch, said ? *said : RecordCheck::Said()));
    epochs.back()["ended"] = epoch.ended && must_end;
    epochs.back()["killed"] = epoch.killed && must_end;
  }
  return nlohmann::json{{"hashed", true}, {"epochs", epochs}}.dump(2) + "\n";
}

}  // namespace

// Folder N of recorder N: everything its disk holds, of two folders what rb recover made of them.
void World::dump(const std::string& folder) {
  for (std::size_t h = 0; h < hosts_.size(); ++h) {
    const auto into = std::filesystem::path(folder) / std::to_string(h + 1);
    std::filesystem::remove_all(into);
    std::filesystem::create_directories(into);
    SimulatedDisk& disk = hosts_[h].machine->disk();
    const std::string from = hosts_[h].machine->record_folder();
    const auto names = disk.list(from.c_str());
    for (const std::string& name : names ? *names : std::vector<std::string>()) {
      const auto bytes = disk.content(from + "/" + name);
      write_file(into / name, reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
    const std::string truth = truth_of(truth_, hosts_[h].machine->check(), hosts_.size() == 1);
    write_file(into / "truth.json", truth.data(), truth.size());
  }
}

}  // namespace roadbalance::test

#include "hil_tests/deterministic/world.hpp"

#include <algorithm>
#include <cmath>

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
  // A recorder that has just begun knows no clock.
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
    node.left = true;
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

// What waited in the socket of a process that slept, or went away with it.
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

}  // namespace roadbalance::test

#include "hil_tests/deterministic/host_machine.hpp"

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

#include "common/bus/control.hpp"
#include "hil_tests/deterministic/host_program.hpp"
#include "host/recorder/incarnation.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kDriveBegins_us = 1'790'000'000'000'000;  // of UTC
// What a recorder may hold in memory: the bound that credit gives it, for each node epoch.
constexpr std::int64_t kMostWaiting = 2048 + 4096;

WallTime wall(std::int64_t ns) {
  return WallTime(std::chrono::nanoseconds(ns));
}

KeeperOptions keeper_options(const FaultScenario& scenario, const std::filesystem::path& folder,
                             std::int64_t least_incarnation) {
  constexpr double kMib = 1024 * 1024;
  KeeperOptions options;
  options.folder = folder;
  options.least_incarnation = least_incarnation;
  if (scenario.fallback) options.fallback = HostMachine::kFallback;
  options.segment_bytes = static_cast<std::uint64_t>(scenario.segment_mib * kMib);
  options.keep_bytes = static_cast<std::int64_t>(scenario.keep_mib * kMib);
  return options;
}

}  // namespace

HostMachine::Program::Program(Disk& disk, const FaultScenario& scenario, const RecorderLinkOptions& options,
                              const std::filesystem::path& folder, std::int64_t utc_us, std::int64_t host_ns,
                              std::int64_t first_incarnation)
    : keeper(disk, keeper_options(scenario, folder, std::max(utc_us / 1000, first_incarnation))),
      link(options, keeper.incarnation(), keeper.recovered()) {
  keeper.set_clocks(utc_us, host_ns);
  keeper.begin();
}

HostMachine::HostMachine(const FaultScenario& scenario, int number, std::uint64_t seed, Truth& truth)
    : scenario_(scenario),
      number_(number),
      truth_(truth),
      random_(seed, 0),
      disk_(random_.bits()),
      check_(truth),
      clock_events_(truth) {
  disk_.set_fault(
      [this](DiskCall call, std::int64_t, const std::string& path) { return disk_call(call, path); });
  disk_.set_cost([this](DiskCall call, std::size_t bytes) { return disk_cost(call, bytes); });
}

HostMachine::~HostMachine() = default;

std::int64_t HostMachine::utc_us(std::int64_t now_ns) const {
  return kDriveBegins_us + now_ns / 1000 + utc_offset_us_;
}

bool HostMachine::boot(std::int64_t now_ns) {
  paused_ = died_ = false;
  calls_to_live_ = 0;
  disk_.power_on();
  try {
    if (scenario_.is_operated()) return boot_operating(now_ns);
    RecorderLinkOptions options;
    options.seed = random_.bits();
    program_ = std::make_unique<Program>(disk_, scenario_, options, kFolder, utc_us(now_ns), now_ns);
  } catch (const std::system_error&) {
    kill();
    return false;  // its supervisor tries again
  }
  durable_.clear();
  for (const auto& [key, epoch] : program_->keeper.recovered().epoch)
    durable_[key] = epoch.position.contiguous;
  ++boots_;
  return true;
}

void HostMachine::kill() {
  died_ = false;
  if (book_may_be_old()) ++unsure_deaths_;
  disk_.kill();
  clock_events_.died();
  program_.reset();
  operating_.reset();
  calls_to_live_ = 0;
}

// Its disk has refused something within the time after which the book is written again.
bool HostMachine::book_may_be_old() const {
  constexpr std::int64_t kWrittenAgain_ns = 1'500'000'000;
  return full_ || now_ns_ - refused_at_ns_ < kWrittenAgain_ns;
}

void HostMachine::cut_power() {
  disk_.cut_power();
  kill();
}

void HostMachine::die_at_call(bool power, int calls, bool only_syncs) {
  if (!is_up()) return;
  dies_of_power_ = power;
  dies_at_sync_ = only_syncs;
  calls_to_live_ = calls;
}

void HostMachine::take(std::string_view channel, std::span<const std::uint8_t> bytes, std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (program_) program_->link.take(channel, bytes, wall(now_ns));
  for (Led* led : led_) led->take(channel, bytes, now_ns);
  if (operating_) operating_->take(channel, bytes, {.now = wall(now_ns), .utc_us = utc_us(now_ns)});
}

void HostMachine::watch(Program& p, const Ack& ack) {
  const std::string name =
      "recorder " + std::to_string(number_) + ", node " + std::to_string(ack.node) + ": ";
  auto [at, is_new] = p.last_ack.try_emplace({ack.node, ack.epoch}, ack);
  const Ack& last = at->second;
  if (!is_new && ack.incarnation == last.incarnation && ack.number <= last.number)
    truth_.fault(name + "an ack number does not rise");
  if (ack.incarnation < last.incarnation || ack.received < last.received || ack.durable < last.durable)
    truth_.fault(name + "an acknowledgement takes back what an earlier one said");
  if (ack.durable > ack.received) truth_.fault(name + "more is durable than received");
  EpochTruth* epoch = truth_.find(ack.node, ack.epoch);
  if (!epoch) return truth_.fault(name + "acknowledges an epoch that nobody began");
  if (ack.received >= epoch->next()) truth_.fault(name + "acknowledges what was never sealed");
  at->second = ack;
  epoch->promised = std::max(epoch->promised, ack.durable);
  check_.promised(ack.node, ack.epoch, ack.durable);
}

void HostMachine::record(RecordEvent event) {
  if (program_) program_->events.push_back(std::move(event));
}

bool HostMachine::say(Program& p, const std::string& channel, std::span<const std::uint8_t> bytes,
                      const Publish& publish) {
  if (channel.starts_with("RB_ACK_")) {
    if (const auto ack = decode_ack(bytes))
      watch(p, *ack);
    else
      truth_.fault("a recorder says an acknowledgement that no node takes");
  }
  return publish(channel, bytes);
}

void HostMachine::became_durable(Program& p, const DurableMark& mark, std::int64_t now_ns) {
  p.link.durable(mark, wall(now_ns));
  const EpochTruth* epoch = truth_.find(mark.node, mark.epoch);
  if (!epoch) return;
  std::int64_t& through = durable_[{mark.node, mark.epoch}];
  for (; through < mark.sequence; ++through)
    if (const auto* block = epoch->block(through + 1))
      longest_to_durable_s_ =
          std::max(longest_to_durable_s_, static_cast<double>(now_ns - block->sealed_ns) * 1e-9);
}

// The writing process: while a sync takes its time nothing is appended, and what comes waits.
void HostMachine::write(Program& p, std::int64_t now_ns) {
  if (now_ns < p.busy_until_ns) return;
  for (const DurableMark& mark : p.marks) became_durable(p, mark, now_ns);
  if (!p.marks.empty()) clock_events_.durable(p.events_in_commit);
  p.marks.clear();
  p.link.set_credit_open(p.keeper.wants_credit());
  p.keeper.set_clocks(utc_us(now_ns), now_ns);
  for (const RecordEvent& event : p.events) {
    clock_events_.given(event.channel, event.bytes);
    p.keeper.append(event, wall(now_ns));
  }
  p.events.clear();
  for (const WriteBatch& batch : p.waiting) append(p.keeper, batch, wall(now_ns));
  p.waiting.clear();
  p.waiting_blocks = 0;
  p.events_in_commit = clock_events_.count();
  if (p.keeper.commit_is_due(wall(now_ns)))
    p.marks = p.keeper.commit(wall(now_ns));
  else
    p.keeper.keep_house();
  if (died_) return;
  p.busy_until_ns = now_ns + take_elapsed_ns();
}

void HostMachine::watch(const WriteBatch& batch) {
  for (const Delivery& delivery : batch.deliveries)
    if (const auto* gap = std::get_if<GapBlock>(&delivery))
      check_.declared(gap->header.node, gap->header.epoch, gap->header.sequence);
}

void HostMachine::receive(Program& p, std::int64_t now_ns, const Publish& publish) {
  if (p.link.obeyed_higher() != 0)
    p.link.set_incarnation(raise_incarnation(p.keeper.folder(), p.link.obeyed_higher(), disk_));
  p.link.turn(wall(now_ns), publish);
  WriteBatch batch = p.batches.take(p.link, wall(now_ns));
  if (!batch.says_something()) return;
  watch(batch);
  p.waiting_blocks += static_cast<std::int64_t>(batch.deliveries.size());
  p.waiting.push_back(std::move(batch));
  if (p.waiting_blocks > kMostWaiting * scenario_.nodes)
    truth_.fault("recorder " + std::to_string(number_) + ": holds more blocks than its credit allows");
}

void HostMachine::turn(std::int64_t now_ns, const Publish& publish) {
  if (operating_) return turn_operating(now_ns, publish);
  Program& p = *program_;
  const Publish say_it = [&](const std::string& channel, std::span<const std::uint8_t> bytes) {
    return say(p, channel, bytes, publish);
  };
  try {
    receive(p, now_ns, say_it);
    write(p, now_ns);
    if (stopping_ && end(p, now_ns, say_it)) {
      program_.reset();
      closed_ = true;
    }
  } catch (const std::system_error& error) {
    if (!died_) truth_.fault("recorder " + std::to_string(number_) + " ends: " + error.what());
    died_ = true;
  }
  if (died_) kill();
}

bool HostMachine::end(Program& p, std::int64_t now_ns, const Publish& publish) {
  p.link.stop(wall(now_ns));
  if (!p.link.over(wall(now_ns)) || !p.waiting.empty() || now_ns < p.busy_until_ns) return false;
  p.link.finish(wall(now_ns));
  const WriteBatch last = BatchMaker::take_last(p.link);
  watch(last);
  append(p.keeper, last, wall(now_ns));
  p.link.farewell(publish);
  p.keeper.close(wall(now_ns));
  return !died_;
}

}  // namespace roadbalance::test

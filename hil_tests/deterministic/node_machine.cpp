#include "hil_tests/deterministic/node_machine.hpp"

#include <algorithm>
#include <cerrno>
#include <span>
#include <string>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"
#include "common/link/planted.hpp"
#include "common/record/folder.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/segment.hpp"
#include "hil_tests/deterministic/node_program.hpp"

namespace roadbalance::test {
namespace {

const std::filesystem::path kSpools = "/spool";

// No encoder: the references are proven elsewhere and cost more than all the rest.
VehicleConfig plain_vehicle(std::int32_t number, double rate_hz, const std::string& text) {
  VehicleConfig vehicle{};
  vehicle.name = "deterministic";
  vehicle.filter.order = 1;
  for (std::size_t w = 0; w < kWheels; ++w) vehicle.wheel[w].name = kWheelNames[w];
  vehicle.node.push_back({.name = "node", .id = number, .rate_hz = rate_hz, .channel = {}});
  vehicle.text = text.empty() ? std::string(2000, '#') : text;  // two meta blocks
  return vehicle;
}

std::size_t bytes_of(double mib) {
  return static_cast<std::size_t>(mib * 1024 * 1024);
}

SpoolFolder::Options spool_options(const FaultScenario& scenario, std::int32_t node, std::int64_t epoch) {
  return {.folder = spool_path(kSpools, node, epoch),
          .bytes = bytes_of(scenario.spool_mib),
          .node = node,
          .epoch = epoch};
}

}  // namespace

NodeMachine::Program::Program(const FaultScenario& scenario, const VehicleConfig& vehicle, std::int32_t node,
                              EpochTruth& of, Truth& all, VehicleChange& change, Disk& disk,
                              const std::int64_t& machine_slept_ns)
    : truth(of),
      beside(all, node, static_cast<std::int64_t>(1e9 / scenario.rate_hz)),
      ring(bytes_of(scenario.ring_mib)),
      sink(ring, all, of, beside),
      packer(vehicle, vehicle.node.front(), of.epoch, sink, &preview),
      spool(scenario.spool_mib > 0
                ? std::make_unique<SpoolFolder>(spool_options(scenario, node, of.epoch), disk)
                : nullptr),
      backlog(ring, spool.get()),
      uplink(node, of.epoch, backlog, preview, link, change),
      samples(node, of.epoch),
      sleeps(handed, scenario.rate_hz,
             [&machine_slept_ns] { return MachineClock::duration(machine_slept_ns); }) {}

NodeMachine::NodeMachine(const FaultScenario& scenario, std::int32_t number, std::uint64_t seed, Truth& truth)
    : scenario_(scenario),
      number_(number),
      truth_(truth),
      random_(seed, 0),
      vehicle_(plain_vehicle(number, scenario.rate_hz, scenario.vehicle)),
      disk_(random_.bits()),
      spool_bytes_(static_cast<std::int64_t>(bytes_of(scenario.spool_mib))),
      clock_offset_ns_(random_.below(std::int64_t{1} << 50)),
      clock_drift_(random_.between(-50e-6, 50e-6)),
      scans_(kScansPerRead),
      numbered_(kScansPerRead),
      counts_(kScansPerRead) {}

NodeMachine::~NodeMachine() = default;

void NodeMachine::boot(std::int64_t now_ns) {
  std::int64_t epoch = static_cast<std::int64_t>(random_.bits() >> 1) | 1;
  if (planted(PlantedFault::kEpochReused) && last_epoch_ != 0) epoch = last_epoch_;
  last_epoch_ = epoch;
  if (!change_) change_.emplace(vehicle_.text, scenario_.is_operated());
  disk_.set_fault(nullptr);
  if (scenario_.spool_mib > 0) (void)left_spools();  // which makes their folder, as rb-node does
  program_ = std::make_unique<Program>(scenario_, vehicle_, number_, truth_.open(number_, epoch), truth_,
                                       *change_, disk_, slept_ns_);
  disk_.set_fault([this](DiskCall call, std::int64_t, const std::string&) {
    if (!random_.chance(spool_failing_)) return SimulatedDisk::Outcome{};
    // Blocks that it does not take stay in memory; only blocks that it does not give back may be given up.
    if (call == DiskCall::kOpen || call == DiskCall::kRead) program_->truth.gave_up = true;
    return SimulatedDisk::Outcome{.error = EIO};
  });
  program_->started_ns = now_ns;
  paused_ = hung_ = false;
}

void NodeMachine::kill(bool power) {
  if (!program_) return;
  program_->truth.killed = !program_->truth.ended || program_->backlog.used() > 0;
  truth_.ends(number_, AbsenceCause::kSilent);
  disk_.set_fault(nullptr);
  if (power) disk_.cut_power();
  disk_.kill();
  disk_.power_on();
  if (program_->spool && program_->spool->base() < program_->spool->next())
    take_left_spool(program_->spool->base(), program_->spool->next());
  program_.reset();
  change_.reset();
  vehicle_.text = plain_vehicle(number_, scenario_.rate_hz, scenario_.vehicle).text;
  was_killed_ = true;
}

void NodeMachine::end(AbsenceCause cause) {
  if (program_) program_->ends = cause;
}

std::vector<std::filesystem::path> NodeMachine::left_spools() {
  return spools_left(
      kSpools, [this](const std::string& what) { fault(what); }, disk_);
}

// `rb recover --spool` finds the contents of its disk there.  The user takes it away.
void NodeMachine::take_left_spool(std::int64_t base, std::int64_t next) {
  const auto folder = spool_path(kSpools, number_, last_epoch_);
  const auto left = left_spools();
  if (std::find(left.begin(), left.end(), folder) == left.end())
    return fault("its spool is not among those that are left");
  RecordReader reader(folder, disk_);
  reader.finish();
  SealedBlock block;
  while (const auto event = reader.next()) {
    if (accept(event->data, block) != Refusal::kNone || block.header.sequence != base) continue;
    const auto* own = program_->truth.block(base);
    if (block.header.epoch == last_epoch_ && (!own || own->crc == crc_of(block))) ++base;
  }
  if (base < next)
    fault("block " + std::to_string(base) + " of its spool is not there, which held those before " +
          std::to_string(next));
  for (const int segment : segment_numbers(folder, disk_)) remove_file(segment_path(folder, segment), disk_);
  sync_folder(folder, disk_);
}

// By the names that are there: what is removed takes space until its folder is synced.
std::int64_t NodeMachine::spool_size() {
  const double failing = std::exchange(spool_failing_, 0);
  const auto folder = spool_path(kSpools, number_, last_epoch_);
  std::int64_t bytes = 0;
  for (const std::string& name : list_folder(folder, disk_))
    bytes += static_cast<std::int64_t>(disk_.content((folder / name).string()).size());
  spool_failing_ = failing;
  return bytes;
}

void NodeMachine::fault(const std::string& what) {
  truth_.fault("node " + std::to_string(number_) + ": " + what);
}

void NodeMachine::pause(bool on) {
  paused_ = on;
}

// Reads first what its device has taken by then: later it could not be distinguished from what it takes
// behind the sleep.
void NodeMachine::suspend(bool on, std::int64_t now_ns) {
  if (on) {
    if (runs()) (void)device(now_ns);
    if (sleeps_++ == 0) asleep_at_ns_ = now_ns;
    return;
  }
  if (--sleeps_ > 0) return;
  const std::int64_t since_ns = std::exchange(asleep_at_ns_, std::nullopt).value_or(now_ns);
  slept_ns_ += clock_ns(now_ns) - clock_ns(since_ns);
  if (!program_) return;
  program_->slept_ns += now_ns - since_ns;
  program_->wakes = program_->latest != NodeTime::min();
  if (program_->wakes) program_->slept_between_scans_ns += now_ns - since_ns;
}

// Protocol timers stand still while the computer sleeps.
WallTime NodeMachine::wall(std::int64_t now_ns) const {
  return WallTime(std::chrono::nanoseconds(clock_ns(now_ns) - slept_ns_));
}

NodeTime NodeMachine::node_time(WallTime wall) const {
  return node_time_from_ns(to_ns(wall) + slept_ns_);
}

std::int64_t NodeMachine::base() const {
  return program_ ? program_->backlog.base() : 1;
}

std::int64_t NodeMachine::next() const {
  return program_ ? program_->backlog.next() : 1;
}

bool NodeMachine::finished() const {
  return program_ && program_->uplink.finished();
}

// Only what the owner's acknowledgement calls durable may be given back.
void NodeMachine::watch_freed(std::string_view channel, std::span<const std::uint8_t> bytes,
                              std::int64_t base_before) {
  Program& p = *program_;
  if (p.uplink.owner() != 0 && p.uplink.owner() < p.highest_owner)
    fault("obeys recorder " + std::to_string(p.uplink.owner()) + " after " + std::to_string(p.highest_owner));
  p.highest_owner = std::max(p.highest_owner, p.uplink.owner());
  if (p.uplink.owner() != 0) p.truth.obeys(p.uplink.owner());
  const std::int64_t base = p.backlog.base();
  if (base == base_before) return;
  // Only what the node's own disk does not give back is given up, which the recorder then declares.
  if (base - 1 > p.truth.promised && !p.truth.gave_up)
    fault("gave back block " + std::to_string(base - 1) + ", durable is " + std::to_string(p.truth.promised));
  const auto ack = channel.starts_with("RB_ACK_") ? decode_ack(bytes) : std::nullopt;
  if (!ack) return;
  p.truth.obeys(ack->incarnation);
  if (ack->incarnation < p.highest_owner) fault("gave blocks back to a recorder of the past");
}

void NodeMachine::take(std::string_view channel, std::span<const std::uint8_t> bytes, std::int64_t now_ns) {
  if (!program_) return;
  const std::int64_t before = program_->backlog.base();
  program_->uplink.take(channel, bytes, wall(now_ns));
  watch_freed(channel, bytes, before);
}

bool NodeMachine::turn(std::int64_t now_ns, const Publish& publish) {
  const std::int64_t before = program_->backlog.base();
  const bool busy = program_->uplink.turn(wall(now_ns), publish);
  watch_freed({}, {}, before);
  if (program_->backlog.used() - program_->backlog.spooled() > program_->ring.capacity())
    fault("holds more blocks in memory than it has room for");
  if (disk_.used_bytes() > spool_bytes_ && spool_size() > spool_bytes_)
    fault("its spool is larger than it may be");
  return busy;
}

void NodeMachine::leave(const Publish& publish) {
  program_->uplink.farewell(publish);
  program_->truth.gone = true;
  disk_.set_fault(nullptr);
  program_.reset();
}

void NodeMachine::begin_anew(std::int64_t now_ns, const Publish& publish) {
  leave(publish);
  constexpr double kDeviceRefuses = 0.1;
  if (change_->wanted() && random_.chance(kDeviceRefuses)) {
    change_->refused("its device cannot");
  } else if (change_->wanted()) {
    vehicle_.text = *change_->wanted();
    change_->made();
  }
  boot(now_ns);
}

std::optional<std::uint32_t> NodeMachine::changed_vehicle() const {
  if (was_killed_ || !change_) return std::nullopt;
  return change_->in_force();
}

namespace {

constexpr std::int64_t kDeviceHolds = 256;  // scans; older ones are lost while they are not read
constexpr std::int64_t kScansPerEdge = 32;

// At an instant of its own between the scan and the one before.
Edge edge_before(const Scan& scan) {
  const std::int64_t number = scan.index / kScansPerEdge;
  return {.time = scan.time - NodeClock::duration(number * 7919 % 20'000),
          .line = static_cast<std::uint8_t>(number % kEncoderLines),
          .kind = number % 97 == 0 ? EdgeKind::kZeroMark : EdgeKind::kTooth};
}

}  // namespace

void NodeMachine::read(std::int64_t now_ns) {
  Program& p = *program_;
  const double since_s = static_cast<double>(now_ns - p.started_ns - p.slept_ns) * 1e-9;
  const auto end = std::max(p.next_index, static_cast<std::int64_t>(since_s * scenario_.rate_hz));
  p.next_index = std::max(p.next_index, end - kDeviceHolds);
  const auto count = static_cast<std::size_t>(end - p.next_index);
  edges_.clear();
  for (std::size_t k = 0; k < count; ++k) {
    Scan& scan = scans_[k];
    scan.index = p.next_index++;
    const auto taken_ns =
        static_cast<std::int64_t>(1e9 / scenario_.rate_hz * static_cast<double>(scan.index));
    scan.time = node_time_from_ns(clock_ns(p.started_ns + taken_ns + p.slept_ns));
    const bool wakes = std::exchange(p.wakes, false);
    if (wakes) skip_sleep(scan);
    if (scan.time >= p.from && !p.has_first) begin_with(scan, wakes);
    if (p.has_first && scan.time < p.to) p.truth.scans = scan.index + p.skipped + 1 - p.first_index;
    p.latest = scan.time;
    if (scan.index % kScansPerEdge == 0) edges_.push_back(edge_before(scan));
  }
  // A sleep is before all of them, or behind.
  p.samples.fill(p.next_index + p.skipped - static_cast<std::int64_t>(count) - p.first_index,
                 std::span(counts_).first(count));
  for (std::size_t k = 0; k < count; ++k) scans_[k].counts = counts_[k];
  p.handed.scans = std::span(scans_).first(count);
  (void)p.sleeps.read(numbered_, {}, {});
  give_what_stands_beside(count);
  p.packer.add(std::span(numbered_).first(count), edges_, false);
}

void NodeMachine::skip_sleep(const Scan& first) {
  Program& p = *program_;
  const std::int64_t skipped = std::llround(to_seconds(first.time - p.latest) * scenario_.rate_hz) - 1;
  p.skipped += skipped;
  if (p.has_first && first.time < p.to) p.skipped_kept += skipped;
}

void NodeMachine::check_sleeps() {
  const Program& p = *program_;
  if (!p.sink.was_full && p.sink.slept_scans != p.skipped_kept)
    fault("declared " + std::to_string(p.sink.slept_scans) + " scans of its sleeps; they were " +
          std::to_string(p.skipped_kept));
  const double skipped_s = static_cast<double>(p.skipped) / scenario_.rate_hz;
  const double slept_s = 1e-9 * static_cast<double>(p.slept_between_scans_ns);
  if (!p.wakes && std::abs(skipped_s - slept_s) > 1e-3 + 1e-4 * skipped_s)
    fault("its gaps are not as long as its sleeps");
}

// The scans that it misses from its instant on count, by its own clock: it heard of that too late, or slept
// through it.
void NodeMachine::begin_with(const Scan& first, bool wakes) {
  Program& p = *program_;
  p.has_first = true;
  p.first_index = first.index + p.skipped;
  const double periods = to_seconds(first.time - p.from) * scenario_.rate_hz;
  const bool gave_before = p.latest != NodeTime::min();
  if (periods < 1.25 || !(p.is_late || gave_before)) return;
  p.first_index -= static_cast<std::int64_t>(periods);
  if (p.is_late) truth_.started_late();
  if (wakes) p.skipped_kept += static_cast<std::int64_t>(periods);
}

// Edges of both lines, and a sample a read: with them blocks without scans, which only their numbers
// reveal.
void NodeMachine::give_what_stands_beside(std::size_t scans) {
  Program& p = *program_;
  if (scans == 0) return;
  const Scan& last = scans_[scans - 1];
  const SignalSample sample{.time = last.time, .signal = 3, .value = static_cast<double>(last.index)};
  const auto is_kept = [&p](NodeTime stamped) { return stamped >= p.from && stamped < p.to; };
  for (const Edge& edge : edges_)
    if (is_kept(edge.time)) p.beside.given(edge);
  if (is_kept(sample.time)) p.beside.given(sample);
  p.packer.add({&sample, 1});
}

// The body of firmware/acquire.cpp's loop, one read of a device that does not wait.
std::int64_t NodeMachine::device(std::int64_t now_ns) {
  constexpr std::int64_t kScansPerVisit = 20;
  const auto more_ns = static_cast<std::int64_t>(static_cast<double>(kScansPerVisit) / scenario_.rate_hz *
                                                 1e9 * random_.between(0.5, 1.5));
  if (!runs() || program_->stopped) return now_ns + more_ns;
  Program& p = *program_;
  const std::int64_t before = p.backlog.base();
  p.sink.now_ns = now_ns;
  p.packer.asked(node_time_from_ns(clock_ns(now_ns)));
  const WallTime start_at = p.link.start_at.load(), stop_at = p.link.stop_at.load();
  if (start_at != AcquireLink::kNotAsked && p.latest < p.from) {
    if (p.from == NodeTime::max()) {
      p.truth.started_by = p.uplink.owner();
      truth_.begins(number_);
    }
    p.from = node_time(start_at);
    p.is_late = p.from <= p.latest;
    p.packer.start(p.from);
  }
  const bool ends = p.ends != AbsenceCause::kNone;
  if (ends || stop_at != AcquireLink::kNotAsked) {
    if (stop_at != AcquireLink::kNotAsked && p.latest < p.to) p.to = node_time(stop_at);
    ends ? p.packer.device_ended() : p.packer.stop(p.to);
    p.stopped = (ends && !p.packer.started()) || p.packer.finish();
    if (p.stopped) check_sleeps();
    p.link.end_cause = ends ? p.ends : AbsenceCause::kStopped;
    truth_.ends(number_, p.link.end_cause);
  }
  if (!p.stopped && !ends) read(now_ns);
  const NodeState state = p.from != NodeTime::max() ? NodeState::kStarted : NodeState::kPreview;
  const NodeState last = p.ends == AbsenceCause::kDeviceFailed ? NodeState::kFailed : NodeState::kEnded;
  report_progress(p.packer, p.stopped ? last : state, p.link);
  watch_freed({}, {}, before);
  return now_ns + more_ns;
}

}  // namespace roadbalance::test

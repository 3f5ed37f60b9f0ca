#include "hil_tests/deterministic/node_machine.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <limits>
#include <string>

#include "common/bus/control.hpp"
#include "common/link/planted.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "firmware/node_link.hpp"
#include "firmware/ring_sink.hpp"
#include "firmware/spool_folder.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kDeviceHolds = 256;  // scans; older ones are lost while nobody reads

// No encoder: the references are somebody else's proof and cost more than all the rest.
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
  return {.folder = "/spool", .bytes = bytes_of(scenario.spool_mib), .node = node, .epoch = epoch};
}

WallTime wall(std::int64_t ns) {
  return WallTime(std::chrono::nanoseconds(ns));
}

/// The ring as the sealer sees it, with a witness.
class WitnessedSink final : public BlockSink {
 public:
  WitnessedSink(Ring& ring, Truth& truth, EpochTruth& epoch) : sink_(ring), truth_(truth), epoch_(epoch) {}
  std::size_t room() const noexcept override { return sink_.room(); }
  SealedBlock* claim() noexcept override { return block_ = sink_.claim(); }
  void commit() noexcept override {
    truth_.sealed(epoch_, *block_, now_ns);
    sink_.commit();
  }
  std::int64_t now_ns = 0;

 private:
  RingSink sink_;
  Truth& truth_;
  EpochTruth& epoch_;
  SealedBlock* block_ = nullptr;
};

}  // namespace

struct NodeMachine::Program {
  Program(const FaultScenario& scenario, const VehicleConfig& vehicle, std::int32_t node, EpochTruth& of,
          Truth& all, VehicleChange& change, std::uint64_t seed)
      : truth(of),
        ring(bytes_of(scenario.ring_mib)),
        sink(ring, all, of),
        sealer(vehicle, vehicle.node.front(), of.epoch, sink, &preview),
        disk(seed),
        spool(scenario.spool_mib > 0
                  ? std::make_unique<SpoolFolder>(spool_options(scenario, node, of.epoch), disk)
                  : nullptr),
        backlog(ring, spool.get()),
        uplink(node, of.epoch, backlog, preview, link, change),
        samples(node, of.epoch) {}

  EpochTruth& truth;
  Ring ring;
  WitnessedSink sink;
  PreviewSlot preview;
  AcquireLink link;
  Sealer sealer;
  SimulatedDisk disk;
  std::unique_ptr<SpoolFolder> spool;
  Backlog backlog;
  NodeLink uplink;
  HashedScans samples;
  std::int64_t next_index = 0;    // of the device
  std::int64_t first_index = -1;  // that is kept
  std::int64_t started_ns = 0;    // the device's index 0
  bool stopped = false;
  std::int64_t highest_owner = 0;
};

NodeMachine::NodeMachine(const FaultScenario& scenario, std::int32_t number, std::uint64_t seed, Truth& truth)
    : scenario_(scenario),
      number_(number),
      truth_(truth),
      random_(seed, 0),
      vehicle_(plain_vehicle(number, scenario.rate_hz, scenario.vehicle)),
      clock_offset_ns_(random_.below(std::int64_t{1} << 50)),
      clock_drift_(random_.between(-50e-6, 50e-6)),
      scans_(kScansPerRead),
      counts_(kScansPerRead) {}

NodeMachine::~NodeMachine() = default;

void NodeMachine::boot(std::int64_t now_ns) {
  std::int64_t epoch = static_cast<std::int64_t>(random_.bits() >> 1) | 1;
  if (planted(PlantedFault::kEpochReused) && last_epoch_ != 0) epoch = last_epoch_;
  last_epoch_ = epoch;
  if (!change_) change_.emplace(vehicle_.text, scenario_.is_operated());
  program_ = std::make_unique<Program>(scenario_, vehicle_, number_, truth_.open(number_, epoch), truth_,
                                       *change_, random_.bits());
  program_->disk.set_fault([this](DiskCall, std::int64_t, const std::string&) {
    if (!random_.chance(spool_failing_)) return SimulatedDisk::Outcome{};
    program_->truth.gave_up = true;
    return SimulatedDisk::Outcome{.error = EIO};
  });
  program_->started_ns = now_ns;
  paused_ = hung_ = false;
}

void NodeMachine::kill() {
  if (!program_) return;
  program_->truth.killed = !program_->truth.ended || program_->backlog.used() > 0;
  program_.reset();
  change_.reset();
  vehicle_.text = plain_vehicle(number_, scenario_.rate_hz, scenario_.vehicle).text;
  was_killed_ = true;
}

void NodeMachine::pause(bool on) {
  paused_ = on;
}

std::int64_t NodeMachine::clock_ns(std::int64_t now_ns) const {
  return now_ns + clock_offset_ns_ + static_cast<std::int64_t>(static_cast<double>(now_ns) * clock_drift_);
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

void NodeMachine::read(std::int64_t now_ns) {
  Program& p = *program_;
  const double since_s = static_cast<double>(now_ns - p.started_ns) * 1e-9;
  const auto end = static_cast<std::int64_t>(since_s * scenario_.rate_hz);
  p.next_index = std::max(p.next_index, end - kDeviceHolds);
  const auto count = static_cast<std::size_t>(end - p.next_index);
  if (p.sealer.started() && p.first_index < 0 && count > 0) p.first_index = p.next_index;
  const std::int64_t first = p.next_index - std::max<std::int64_t>(0, p.first_index);
  p.samples.fill(first, std::span(counts_).first(count));
  for (std::size_t k = 0; k < count; ++k) {
    Scan& scan = scans_[k];
    scan.index = p.next_index++;
    const auto taken_ns =
        static_cast<std::int64_t>(1e9 / scenario_.rate_hz * static_cast<double>(scan.index));
    scan.time = node_time_from_ns(clock_ns(p.started_ns + taken_ns));
    scan.counts = counts_[k];
  }
  p.sealer.add(std::span(scans_).first(count), {}, false);
  if (count > 0) {  // blocks without scans, which nothing tells of but their numbers
    const Scan& last = scans_[count - 1];
    const SignalSample sample{.time = last.time, .signal = 3, .value = static_cast<double>(last.index)};
    p.sealer.add({&sample, 1});
  }
  if (p.first_index >= 0 && !p.link.stop.load()) p.truth.scans = p.next_index - p.first_index;
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
  if (p.link.start.load() && !p.sealer.started()) {
    p.sealer.start();
    p.truth.started_by = p.uplink.owner();
  }
  if (p.link.stop.load()) {
    p.sealer.stop();
    p.stopped = p.sealer.finish();
  }
  if (!p.stopped) read(now_ns);
  const NodeState state = p.sealer.started() ? NodeState::kStarted : NodeState::kPreview;
  tell(p.sealer, p.stopped ? NodeState::kEnded : state, p.link);
  watch_freed({}, {}, before);
  return now_ns + more_ns;
}

// Only what the owner's acknowledgement calls durable may be given back.
void NodeMachine::watch_freed(std::string_view channel, std::span<const std::uint8_t> bytes,
                              std::int64_t base_before) {
  Program& p = *program_;
  const auto fault = [this](const std::string& what) {
    truth_.fault("node " + std::to_string(number_) + ": " + what);
  };
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
  program_->uplink.take(channel, bytes, wall(clock_ns(now_ns)));
  watch_freed(channel, bytes, before);
}

bool NodeMachine::turn(std::int64_t now_ns, const Publish& publish) {
  const std::int64_t before = program_->backlog.base();
  const bool busy = program_->uplink.turn(wall(clock_ns(now_ns)), publish);
  watch_freed({}, {}, before);
  if (program_->backlog.used() > program_->backlog.capacity())
    truth_.fault("node " + std::to_string(number_) + ": holds more blocks than it has room for");
  return busy;
}

void NodeMachine::leave(const Publish& publish) {
  program_->uplink.farewell(publish);
  program_->truth.gone = true;
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

}  // namespace roadbalance::test

#include "firmware/node.hpp"

#include <cassert>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/bus/bus_route.hpp"
#include "common/config/section.hpp"
#include "common/link/spool.hpp"
#include "common/process/parallel.hpp"
#include "common/process/pause.hpp"
#include "common/process/realtime.hpp"
#include "firmware/acquire.hpp"
#include "firmware/block_packer.hpp"
#include "firmware/clock_answer.hpp"
#include "firmware/clock_place.hpp"
#include "firmware/describe.hpp"
#include "firmware/device_diary.hpp"
#include "firmware/life_watch.hpp"
#include "firmware/readout_clock.hpp"
#include "firmware/ring_sink.hpp"
#include "firmware/sleep_gaps.hpp"
#include "firmware/spool_folder.hpp"
#include "firmware/uplink.hpp"

namespace roadbalance {
namespace {

/// Stands for a disk that could not be opened: it takes nothing, and that counts as one failure.
class UnopenedSpool final : public Spool {
 public:
  std::int64_t base() const override { return 1; }
  std::int64_t next() const override { return 1; }
  std::int64_t capacity() const override { return 0; }
  std::int64_t failures() const override { return 1; }
  void describe(const SealedBlock&) override {}
  void keep(const Ring&, std::int64_t, std::int64_t, WallTime) override {}
  void never_wait() override {}
  bool read(std::int64_t, SealedBlock&) override {
    assert(false);  // it holds nothing
    return false;
  }
  bool answers() override { return false; }
  void free_through(std::int64_t) override {}
  void give_up_through(std::int64_t) override {}
};

std::int64_t random_epoch() {
  std::random_device device;
  std::uniform_int_distribution<std::int64_t> positive(1, std::numeric_limits<std::int64_t>::max());
  return positive(device);
}

NodeClockAddress clock_address(const ClockPlace* clock) {
  if (clock == nullptr) return {.time_base = TimeBase::kShared};
  const UdpAddress at = clock->address();
  return {.time_base = TimeBase::kOwn, .address = at.address, .port = at.port};
}

/// The spool of this run; nullptr: none is wanted.
std::unique_ptr<SpoolFolder> open_spool(const NodeConfig& node, std::int64_t epoch,
                                        const NodeOptions& options) {
  if (options.spool.empty()) return nullptr;
  if (options.spool_bytes < SpoolFolder::kLeastBytes)
    throw ConfigError("spool " + options.spool.string() + ": at least " +
                      std::to_string(SpoolFolder::kLeastBytes) + " bytes are needed");
  for (const auto& left : spools_left(options.spool, options.warn))
    options.warn("an earlier run left blocks in " + left.string() +
                 ": `rb recover --spool` takes them into their recording");
  return std::make_unique<SpoolFolder>(
      SpoolFolder::Options{.folder = spool_path(options.spool, node.id, epoch),
                           .bytes = options.spool_bytes,
                           .node = node.id,
                           .epoch = epoch});
}

/// A node that stays was started with a spool that could be opened: its disk has failed since, and the ring
/// alone still measures the next drive.
std::unique_ptr<Spool> open_spool_or_go_on(const NodeConfig& node, std::int64_t epoch,
                                           const NodeOptions& options, bool is_first) {
  try {
    return open_spool(node, epoch, options);
  } catch (const std::system_error& error) {
    if (is_first) throw;
    options.warn("node " + node.name + ": blocks are kept in memory only: " + error.what());
    return std::make_unique<UnopenedSpool>();
  }
}

/// Process: counters of devices and encoders -> sentences for people, twice a second at most.
void keep_diary(std::stop_token stop, const FrontEnd& front_end, const AcquireLink& link,
                const NodeOptions& options, bool is_first) {
  auto reports = front_end.reports();
  for (const DeviceReport& encoder : link.encoder) reports.push_back(&encoder);
  DeviceDiary diary(std::move(reports));
  if (!is_first) diary.look([](const std::string&) {});
  do diary.look(options.warn);
  while (pause(stop, std::chrono::milliseconds(500)));
  diary.look(options.warn);
}

/// Process: proof of life.
void prove_life(std::stop_token stop, const AcquireLink& link, const NodeOptions& options) {
  LifeWatch watch(link);
  while (pause(stop, std::chrono::milliseconds(500)))
    if (watch.both_turned()) options.on_alive();
}

/// Saves what no recorder has.  Returns how many blocks are lost with this program.
std::int64_t leave(Backlog& backlog, bool has_spool, const std::filesystem::path& folder,
                   const NodeOptions& options) {
  if (has_spool) {
    backlog.save(WallClock::now());
    std::error_code ignored;
    if (backlog.spooled() == 0)
      std::filesystem::remove(folder, ignored);  // it is empty, or another program put something there
    else
      options.warn(std::to_string(backlog.spooled()) + " blocks that no recorder has stay in " +
                   folder.string());
  }
  const std::int64_t lost = backlog.used() - backlog.spooled();
  if (lost > 0) options.warn(std::to_string(lost) + " blocks that no recorder has are lost");
  return lost;
}

}  // namespace

std::int64_t run_node(std::stop_token stop, const VehicleConfig& vehicle, const NodeConfig& node,
                      FrontEnd& front_end, const NodeOptions& options) {
  VehicleChange none(vehicle.text, false);
  return run_epoch(stop, vehicle, node, front_end, options, none, true).lost;
}

EpochResult run_epoch(std::stop_token stop, const VehicleConfig& vehicle, const NodeConfig& node,
                      FrontEnd& front_end, const NodeOptions& options, VehicleChange& change, bool is_first) {
  const std::int64_t epoch = random_epoch();
  Ring ring(options.ring_bytes);
  RingSink sink(ring);
  const auto preview = std::make_unique<PreviewSlot>();
  AcquireLink link;
  BlockPacker packer(vehicle, node, epoch, sink, preview.get());
  const std::size_t least = 2 * packer.most_blocks(kScansPerRead, kEdgesPerRead, kSignalsPerRead);
  if (static_cast<std::size_t>(ring.capacity()) < least)
    throw ConfigError("ring of " + std::to_string(options.ring_bytes) + " bytes: node " + node.name +
                      " needs at least " + std::to_string(least * sizeof(SealedBlock)));

  const auto spool = open_spool_or_go_on(node, epoch, options, is_first);
  Backlog backlog(ring, spool.get());
  ConversionTimes conversions(front_end, node.rate_hz);
  SleepGaps device(conversions, node.rate_hz);
  std::optional<ClockPlace> clock;
  const auto warn_of_clock = [&](const std::string& why) {
    options.warn("node " + node.name + ": nobody can ask for its clock on " + options.bus_url + ": " + why);
  };
  if (!front_end.waits()) {  // else its time is not of this machine
    clock.emplace([&] { return address_on_bus(options.bus_url); });
    if (const std::string why = clock->follow(); !why.empty()) warn_of_clock(why);
  }
  const auto clock_now = [&] { return clock_address(clock ? &*clock : nullptr); };
  NodeLink node_link(node.id, epoch, backlog, *preview, link, change, clock_now, front_end.reports());
  Parallel processes;
  const std::stop_callback pass_on(stop, [&processes] { processes.request_stop(); });
  processes.run([&](std::stop_token stop_here) {
    const auto open = [&] { return open_node_bus(options.bus_url, node.id, node_link); };
    uplink(stop_here, open, node_link, options.warn);
    processes.request_stop();  // acquire has ended; the clock answers as long as the node lives
  });
  processes.run(describe, options.bus_url, std::cref(vehicle), std::cref(node));
  processes.run(
      [&](std::stop_token stop_here) { keep_diary(stop_here, front_end, link, options, is_first); });
  processes.run(prove_life, std::cref(link), std::cref(options));
  if (clock)
    processes.run(answer_clock, std::ref(*clock), node.id, epoch, std::cref(front_end), warn_of_clock);
  processes.run([&](std::stop_token stop_here) {
    if (!front_end.waits())
      for (const std::string& refused : enter_realtime(kAcquirePriority))
        if (is_first) options.warn(refused);
    acquire(stop_here, device, packer, sink, link);
  });
  std::exception_ptr failure;
  try {
    processes.wait();
  } catch (...) {
    failure = std::current_exception();  // what was measured is saved first
  }
  const std::int64_t lost =
      leave(backlog, spool != nullptr, spool_path(options.spool, node.id, epoch), options);
  if (failure) std::rethrow_exception(failure);
  if (const std::int64_t refused = link.scans_refused.load(); refused > 0)
    options.warn("front end of node " + node.name + " numbered " + std::to_string(refused) +
                 " scans backwards; they are not recorded");
  if (link.state.load() == NodeState::kFailed)
    throw std::runtime_error("front end of node " + node.name + " failed");
  return {.lost = lost, .device_ended = link.device_ended.load()};
}

}  // namespace roadbalance

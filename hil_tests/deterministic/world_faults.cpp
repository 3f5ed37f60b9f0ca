#include "hil_tests/deterministic/world.hpp"

namespace roadbalance::test {
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
      if (on) node.machine->kill(timed.chance < 0.5);
      if (!on) boot_node(which);
      return;
    case FaultKind::kPauseNode:
      node.machine->pause(on);
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

}  // namespace roadbalance::test

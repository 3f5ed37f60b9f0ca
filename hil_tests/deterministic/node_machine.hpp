#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/bus/publish.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "common/types/scan.hpp"
#include "firmware/vehicle_change.hpp"
#include "hil_tests/deterministic/fault_scenario.hpp"
#include "hil_tests/deterministic/hashed_sample.hpp"
#include "hil_tests/deterministic/random.hpp"
#include "hil_tests/deterministic/truth.hpp"

namespace roadbalance::test {

/// A worker node: the product's packer, ring, spool and link, with a device, a clock and a power switch of
/// the world's.  The truth gets all that it takes and seals.
class NodeMachine {
 public:
  NodeMachine(const FaultScenario& scenario, std::int32_t number, std::uint64_t seed, Truth& truth);
  ~NodeMachine();

  void boot(std::int64_t now_ns);
  /// @param power  what its disk has not synced is gone or torn
  void kill(bool power);
  /// It ends in order: everything up to now is sealed, and it stays until its owner has that.
  void end(AbsenceCause cause);
  bool runs() const { return program_ != nullptr && !paused_ && !asleep_at_ns_; }
  bool is_up() const { return program_ != nullptr; }
  /// SIGSTOP and SIGCONT.
  void pause(bool on);
  /// Its computer, with its device, which samples nothing meanwhile.
  void suspend(bool on, std::int64_t now_ns);
  /// The link process alone.
  void hang(bool on) { hung_ = on; }
  bool hangs() const { return hung_ || !runs(); }

  /// Each call of its own disk fails with this probability; 0: none.
  void fail_spool(double probability) { spool_failing_ = probability; }

  /// The device has what it took until now.  Returns when it will have more.
  std::int64_t device(std::int64_t now_ns);
  void take(std::string_view channel, std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  /// True if it is busy.
  bool turn(std::int64_t now_ns, const Publish& publish);
  /// Its program ends as finished() requires.
  void leave(const Publish& publish);
  bool finished() const;
  /// It stays: as leave(), and then a new epoch, with another vehicle.toml if one is wanted and its devices
  /// take it.
  void begin_anew(std::int64_t now_ns, const Publish& publish);
  /// CRC-32C of the vehicle.toml in force; nothing if it was killed at some time and so has that of its first
  /// start.
  std::optional<std::uint32_t> changed_vehicle() const;

  std::int32_t number() const { return number_; }
  std::int64_t epoch() const { return last_epoch_; }  ///< the latest
  std::int64_t base() const;
  std::int64_t next() const;
  std::int64_t used() const { return next() - base(); }
  /// Its clock, for exchanges.
  std::int64_t clock_ns(std::int64_t now_ns) const {
    return now_ns + clock_offset_ns_ + static_cast<std::int64_t>(static_cast<double>(now_ns) * clock_drift_);
  }

 private:
  struct Program;
  WallTime wall(std::int64_t now_ns) const;
  NodeTime node_time(WallTime wall) const;
  void read(std::int64_t now_ns);
  void begin_with(const Scan& first, bool wakes);
  void skip_sleep(const Scan& first);
  void check_sleeps();
  void give_what_stands_beside(std::size_t scans);
  std::vector<std::filesystem::path> left_spools();
  std::int64_t spool_size();
  void take_left_spool(std::int64_t base, std::int64_t next);
  void fault(const std::string& what);
  void watch_freed(std::string_view what, std::span<const std::uint8_t> bytes, std::int64_t base_before);

  const FaultScenario& scenario_;
  const std::int32_t number_;
  Truth& truth_;
  Random random_;
  VehicleConfig vehicle_;
  std::optional<VehicleChange> change_;  // outlives the epochs
  bool was_killed_ = false;
  SimulatedDisk disk_;  // outlives the epochs, and what uses it
  std::unique_ptr<Program> program_;
  bool paused_ = false;
  int sleeps_ = 0;  // that are under way
  std::optional<std::int64_t> asleep_at_ns_;
  std::int64_t slept_ns_ = 0;  // by its clock
  bool hung_ = false;
  double spool_failing_ = 0;
  std::int64_t last_epoch_ = 0;
  const std::int64_t spool_bytes_;
  std::int64_t clock_offset_ns_;
  double clock_drift_;
  std::vector<Scan> scans_;               // of one read
  std::vector<Scan> numbered_;            // the same, as the node's front end gives them
  std::vector<HashedScans::Row> counts_;  // of these
  std::vector<Edge> edges_;               // beside them
};

}  // namespace roadbalance::test

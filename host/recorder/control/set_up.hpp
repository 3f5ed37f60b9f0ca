#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "common/bus/operation.hpp"
#include "common/bus/publish.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/record/disk.hpp"
#include "host/recorder/control/requested_vehicle.hpp"
#include "host/recorder/control/session_state.hpp"
#include "host/recorder/control/vehicle_push.hpp"

namespace roadbalance {

/// Range, filter, zero, scale and vehicle file, between recordings: changes the recorder's vehicle.toml and
/// puts it in force at the nodes.  The file is written when every node has taken it, and else stays as it
/// is.  A disk that refuses the file is tried again for kDiskPatience; then the nodes get the old text back,
/// unless the new file can be read by then: a reader of the file, a recorder after a crash or a node that
/// starts, finds the text by which the nodes measure.
///
/// A change begins a new epoch at each node: the meaning of a count is declared once, before an epoch's first
/// sample, and the record stays one that each reader understands.
class SetUp {
 public:
  static constexpr std::chrono::seconds kDiskAgain{1};
  static constexpr std::chrono::seconds kDiskPatience{20};  ///< as long as for a node

  /// @param file        vehicle.toml in force; those beside it can be chosen
  /// @param recordings  remembers the choice
  /// @param seed        of request numbers, which two recorders must not share
  /// @throws std::system_error if the file cannot be read, ConfigError if it is none
  SetUp(std::filesystem::path file, std::filesystem::path recordings, std::uint64_t seed,
        Disk& disk = kernel_disk());

  /// @param nodes  that are there
  /// @return the answer, which may be that it is under way
  Answer take(const Request& request, const std::vector<std::int32_t>& nodes, std::int64_t utc_us,
              WallTime now);
  /// The request that take() began, for the session state; nothing of it was done so far.
  AskedSetUp asked() const;
  void forget() { change_.reset(); }
  /// A change of a recorder before that was killed meanwhile: each of its nodes gets the file.  The last word
  /// on it is that it is done if the file had been written by then, and else that it is undone.
  void resume(const AskedSetUp& asked, std::int64_t utc_us, WallTime now);
  void take(const Reply& reply);
  void take(const ScanBlock& preview, WallTime now) { requested_.take(preview, now); }

  /// Sends what is due.  @return the last word on what was under way, once
  std::optional<Answer> turn(const Publish& publish, std::int64_t utc_us, WallTime now);

  bool is_under_way() const { return change_.has_value(); }
  /// As it is in force.
  VehicleConfig vehicle() const { return VehicleConfig::parse(text_, file_.string()); }
  const std::filesystem::path& file() const { return file_; }
  /// The CRC of its text, as in the nodes' heartbeats.
  std::uint32_t crc32c() const { return crc32c_; }
  /// A recording by it writes about so much.
  double bytes_per_s() const { return bytes_per_s_; }

 private:
  struct Change {
    Request request;
    std::filesystem::path file;  ///< that is in force then
    std::string done;            ///< for people
    VehiclePush push;
    std::vector<std::int32_t> nodes;
    std::optional<std::uint32_t> resumes{};  ///< CRC of the text that a recorder before was to put in force
    std::optional<WallTime> taken_at{};      ///< by all nodes; the disk is what is waited for
    WallTime tried_at{};
    std::string disk_error{};  ///< of the last try
  };
  /// The small file that decides what is in force: vehicle.toml, or the one that names which of those beside
  /// it is chosen.
  struct Kept {
    std::filesystem::path path;
    std::string before, after;
  };
  Kept kept(const Change& change) const;
  bool is_settled(WallTime now);
  bool reads_new(const Change& change) const;
  std::string put_back(const Change& change);
  void conclude(VehiclePush::State state, Answer& answer);
  void lead(const Change& change);
  void set_text(std::string text);

  std::filesystem::path file_;
  const std::filesystem::path recordings_;
  std::mt19937_64 random_;
  Disk& disk_;
  std::string text_;
  std::uint32_t crc32c_ = 0;
  double bytes_per_s_ = 1;
  RequestedVehicle requested_;
  std::optional<Change> change_;
};

}  // namespace roadbalance

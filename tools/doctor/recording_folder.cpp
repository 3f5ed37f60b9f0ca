#include "tools/doctor/recording_folder.hpp"

#include <linux/magic.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <numbers>
#include <system_error>

#include "common/record/file.hpp"
#include "common/text/format.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {
namespace {

/// As one word of a shell's command.
std::string quoted(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

const std::string kElsewhere = "rb doctor --folder ANOTHER_FOLDER";

/// The folder itself, or the nearest one above it that exists: where it would be created.
std::filesystem::path existing_part(std::filesystem::path folder) {
  folder = std::filesystem::absolute(folder);
  while (!std::filesystem::exists(folder) && folder.has_relative_path()) folder = folder.parent_path();
  return folder;
}

/// Bytes of a block of 20 scans with its header in the log, over those of its samples alone.
constexpr double kScanShare = 1395.0 / 1280.0;
constexpr double kBytesASample = 4;

}  // namespace

Finding writable_folder(const std::filesystem::path& folder) {
  const std::filesystem::path place = existing_part(folder);
  // Only creating a file proves it: permission bits do not show a read-only disk.
  std::string probe = (place / ".rb-doctor-XXXXXX").string();
  const int file = mkstemp(probe.data());
  if (file < 0) return unwritable_folder(folder, place, errno);
  close(file);
  unlink(probe.c_str());
  return {"folder", Finding::kWell, "Recordings can be written to " + folder.string() + ".", ""};
}

Finding unwritable_folder(const std::filesystem::path& folder, const std::filesystem::path& place,
                          int error) {
  Finding finding{"folder", Finding::kIll,
                  "Recordings cannot be written to " + folder.string() + ": " + place.string() +
                      " takes no new file (" + std::generic_category().message(error) + ").",
                  kElsewhere};
  // An existing folder may be another program's: it is left alone, a new one is made.
  const auto wanted = std::filesystem::exists(folder) ? folder / "recordings" : folder;
  if (error == EACCES || error == EPERM)
    finding.remedy = "sudo install -d -o \"$USER\" " + quoted(std::filesystem::absolute(wanted).string());
  if (error == ENOSPC) finding.remedy = "df -h " + quoted(place.string()) + "  # says how full it is";
  return finding;
}

std::optional<Finding> file_system(const std::filesystem::path& folder, std::int64_t kind) {
  const auto note = [](const std::string& sentence, const std::string& remedy) {
    return Finding{"file_system", Finding::kNote, sentence, kElsewhere + remedy};
  };
  const std::string there = folder.string();
  switch (kind) {
    case TMPFS_MAGIC:
    case RAMFS_MAGIC:
      return note(there + " is in memory: when the machine goes off, all that was recorded there is gone.",
                  "");
    case MSDOS_SUPER_MAGIC:
    case EXFAT_SUPER_MAGIC:
      return note(
          there + " is on FAT, which has no journal: a power cut may cost more there than the last commit.",
          "  # on ext4, xfs or btrfs; rb transfer takes it to the stick afterwards");
    case NFS_SUPER_MAGIC:
    case SMB_SUPER_MAGIC:
    case CIFS_SUPER_MAGIC:
    case SMB2_SUPER_MAGIC:
    case AFS_SUPER_MAGIC:
    case CEPH_SUPER_MAGIC:
    case V9FS_MAGIC:
      return note(there +
                      " is on another machine: while the way to it fails nothing is recorded, and nodes lose "
                      "what their memory cannot hold.",
                  "  # of this machine; rb transfer takes it there afterwards");
    default:
      return std::nullopt;
  }
}

RecordingRate ordinary_rate() {
  return {.of = "three nodes of 16 channels at 2 kHz",
          .bytes_s = 3 * kChannels * 2000 * kBytesASample * kScanShare};
}

RecordingRate rate_of(const VehicleConfig& vehicle) {
  constexpr double kFast_m_s = 130.0 / 3.6, kBytesAnEdge = 3;
  constexpr double kSignal_hz = 100, kBytesASignal = 18;
  RecordingRate rate{.of = "\"" + vehicle.name + "\""};
  for (const NodeConfig& node : vehicle.node)
    rate.bytes_s += kChannels * node.rate_hz * kBytesASample * kScanShare +
                    static_cast<double>(node.wiring.signals()) * kSignal_hz * kBytesASignal;
  for (const WheelConfig& wheel : vehicle.wheel)
    if (!wheel.node.empty())
      rate.bytes_s += wheel.encoder.pulses_per_turn * kBytesAnEdge * kFast_m_s /
                      (2.0 * std::numbers::pi * wheel.rolling_radius_m);
  return rate;
}

DiskMeasurement measure_disk(const std::filesystem::path& folder) {
  const std::filesystem::path place = existing_part(folder);
  DiskMeasurement measured{.free_bytes = std::filesystem::space(place).available};
  const std::filesystem::path probe = place / (".rb-doctor-" + std::to_string(getpid()));
  File file = File::create(probe);
  std::filesystem::remove(probe);  // it lives as long as it is open
  const std::vector<std::uint8_t> block(64 * 1024);
  constexpr int kSyncs = 20;
  for (int k = 0; k < kSyncs; ++k) {
    file.write_all(block);
    const auto begin = std::chrono::steady_clock::now();
    file.sync_data();
    measured.worst_sync = std::max<std::chrono::duration<double>>(measured.worst_sync,
                                                                  std::chrono::steady_clock::now() - begin);
  }
  return measured;
}

Finding disk(const std::filesystem::path& folder, const DiskMeasurement& measured,
             const RecordingRate& rate) {
  constexpr double kLongDrive_h = 8.0, kCommit_s = 0.2;
  const double hours = static_cast<double>(measured.free_bytes) / rate.bytes_s / 3600.0;
  const std::string sentence = format(
      "The disk of %s has room for %.0f h of %s, and takes %.1f ms at worst until data are safe on it.",
      folder.c_str(), hours, rate.of.c_str(), 1e3 * measured.worst_sync.count());
  if (hours < kLongDrive_h)
    return {"disk", Finding::kNote, sentence, "rb transfer FOLDER ANOTHER_DISK  # then make room"};
  if (measured.worst_sync.count() > kCommit_s)
    return {"disk", Finding::kNote,
            sentence + "  That is longer than a commit: what a power cut costs grows with it.", kElsewhere};
  return {"disk", Finding::kWell, sentence, ""};
}

std::vector<Finding> examine_folder(const std::filesystem::path& folder, const RecordingRate& rate) {
  std::vector<Finding> findings{writable_folder(folder)};
  if (findings.back().state != Finding::kWell) return findings;
  findings.push_back(disk(folder, measure_disk(folder), rate));
  struct statfs of {};
  if (statfs(existing_part(folder).c_str(), &of) != 0) return findings;
  if (const auto finding = file_system(folder, of.f_type & 0xFFFFFFFF)) findings.push_back(*finding);
  return findings;
}

}  // namespace roadbalance

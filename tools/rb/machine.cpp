#include "tools/rb/machine.hpp"

#include <sys/resource.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numbers>
#include <optional>
#include <sstream>
#include <system_error>

#include "common/bus/bus.hpp"
#include "common/record/file.hpp"

namespace roadbalance {
namespace {

std::string read_all(const char* path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// 239.255.76.67, least significant byte first as in the kernel's table.
constexpr std::uint32_t kGroup = 0x434CFFEF;

std::optional<std::uint32_t> hexadecimal(const std::string& text) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, 16);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// As one word of a shell's command.
std::string quoted(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

constexpr const char* kRealtimeRemedy =
    "echo \"$USER - rtprio 50\" | sudo tee /etc/security/limits.d/roadbalance.conf  # then log in again";

std::string as_root(const std::string& commands) {
  return "sudo sh -c '" + commands + "'";
}

/// The folder itself, or the nearest one above it that exists: where it would be created.
std::filesystem::path existing_part(std::filesystem::path folder) {
  folder = std::filesystem::absolute(folder);
  while (!std::filesystem::exists(folder) && folder.has_relative_path()) folder = folder.parent_path();
  return folder;
}

}  // namespace

// Columns: interface, destination, gateway, flags, ..., mask (8th), hexadecimal, least significant byte
// first.  Any route that holds LCM's group will do.
bool has_multicast_route(const std::string& route_table) {
  std::istringstream lines(route_table);
  std::string line;
  std::getline(lines, line);  // header
  while (std::getline(lines, line)) {
    std::istringstream columns(line);
    std::array<std::string, 8> column;
    for (auto& text : column) columns >> text;
    const auto destination = hexadecimal(column[1]), mask = hexadecimal(column[7]);
    if (destination && mask && (kGroup & *mask) == *destination) return true;
  }
  return false;
}

Finding multicast_route(const std::string& route_table) {
  if (has_multicast_route(route_table))
    return {"multicast_route", Finding::kWell, "There is a route for multicast, which LCM needs.", ""};
  return {"multicast_route", Finding::kIll,
          "There is no route for multicast (224.0.0.0/4), which LCM needs even on one machine.",
          as_root(kMulticastRemedy)};
}

Finding receive_buffer(std::int64_t rmem_max_bytes) {
  const std::string is = "net.core.rmem_max is " + std::to_string(rmem_max_bytes) + " bytes";
  if (rmem_max_bytes >= kReceiveBufferBytes)
    return {"receive_buffer", Finding::kWell, is + ", enough for the bus.", ""};
  return {"receive_buffer", Finding::kNote,
          is + ", less than the 4 MiB that let a busy recorder listen without asking for repeats.",
          "sudo sysctl -w net.core.rmem_max=" + std::to_string(kReceiveBufferBytes)};
}

Finding writable_folder(const std::filesystem::path& folder) {
  const std::filesystem::path place = existing_part(folder);
  // Only a file tells: permission bits say nothing of a read-only disk.
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
                  "rb doctor --folder ANOTHER_FOLDER"};
  // A folder that is there belongs to somebody: it is left alone, a new one is made.
  const auto wanted = std::filesystem::exists(folder) ? folder / "recordings" : folder;
  if (error == EACCES || error == EPERM)
    finding.remedy = "sudo install -d -o \"$USER\" " + quoted(std::filesystem::absolute(wanted).string());
  if (error == ENOSPC) finding.remedy = "df -h " + quoted(place.string()) + "  # says how full it is";
  return finding;
}

Finding realtime_priority(std::int64_t limit, bool root) {
  if (root || limit > 0) return {"realtime", Finding::kWell, "A node may run with real-time priority.", ""};
  return {"realtime", Finding::kNote,
          "A node may not run with real-time priority; its ring then has to outlast a busy machine.",
          kRealtimeRemedy};
}

Finding wall_clock(bool synchronised) {
  if (synchronised) return {"clock", Finding::kWell, "This machine's clock is kept right.", ""};
  return {
      "clock", Finding::kNote,
      "Nobody keeps this machine's clock right: dates of recordings may be wrong, times within one are not.",
      "sudo timedatectl set-ntp true"};
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

// Three nodes of 16 channels at 2 kHz, four bytes a sample as a block holds at most.
Finding disk(const std::filesystem::path& folder, const DiskMeasurement& measured) {
  constexpr double kBytes_s = 3 * 16 * 2000 * 4.0;
  constexpr double kLongDrive_h = 8.0, kCommit_s = 0.2;
  const double hours = static_cast<double>(measured.free_bytes) / kBytes_s / 3600.0;
  std::array<char, 300> text;
  std::snprintf(
      text.data(), text.size(),
      "The disk of %s has room for %.0f h of three nodes of 16 channels at 2 kHz, and takes %.1f ms at worst "
      "until data are safe on it.",
      folder.c_str(), hours, 1e3 * measured.worst_sync.count());
  if (hours < kLongDrive_h)
    return {"disk", Finding::kNote, text.data(), "rb transfer FOLDER ANOTHER_DISK  # then make room"};
  if (measured.worst_sync.count() > kCommit_s)
    return {
        "disk", Finding::kNote,
        text.data() + std::string("  That is longer than a commit: what a power cut costs grows with it."),
        "rb doctor --folder ANOTHER_DISK"};
  return {"disk", Finding::kWell, text.data(), ""};
}

// A wheel of 0.3 m at 250 km/h turns 36.8 times a second.
Finding encoder_edges(const WakeUpMeasurement& measured) {
  constexpr double kRing_hz = 96 * 250.0 / 3.6 / (2.0 * std::numbers::pi * 0.3);
  const double limit_hz = edge_limit_hz(measured.worst);
  const auto ms = [](auto time) { return std::chrono::duration<double, std::milli>(time).count(); };
  std::array<char, 400> text;
  std::snprintf(
      text.data(), text.size(),
      "Encoder edges by GPIO: in %.0f s threads%s woke up %.2f ms late at worst where the kernel takes "
      "edges one by one, %.2f ms where a node takes up to 16: up to %.1f kHz a line then; a 96-tooth "
      "ring at 250 km/h needs %.1f kHz.",
      ms(measured.duration) / 1000.0, measured.realtime ? "" : " (without real-time priority)",
      ms(measured.worst.interrupt_thread), ms(measured.worst.reader), limit_hz / 1000.0, kRing_hz / 1000.0);
  if (limit_hz >= kRing_hz) return {"encoder_edges", Finding::kWell, text.data(), ""};
  return {"encoder_edges", Finding::kNote,
          text.data() + std::string("  Turns with lost edges are flagged; the USB board loses none."),
          measured.realtime
              ? "sudo apt-get install linux-image-rt-amd64  # a kernel with PREEMPT_RT; then reboot"
              : kRealtimeRemedy};
}

std::vector<Finding> examine_machine(const std::filesystem::path& folder,
                                     std::chrono::milliseconds wake_ups) {
  std::int64_t rmem_max = 0;
  std::istringstream(read_all("/proc/sys/net/core/rmem_max")) >> rmem_max;
  rlimit limit{};
  getrlimit(RLIMIT_RTPRIO, &limit);
  const auto priority = limit.rlim_cur == RLIM_INFINITY ? 99 : static_cast<std::int64_t>(limit.rlim_cur);
  std::vector<Finding> findings{multicast_route(read_all("/proc/net/route")), receive_buffer(rmem_max),
                                writable_folder(folder)};
  if (findings.back().state == Finding::kWell) findings.push_back(disk(folder, measure_disk(folder)));
  timex clock{};
  findings.push_back(wall_clock(adjtimex(&clock) != TIME_ERROR));
  findings.push_back(realtime_priority(priority, geteuid() == 0));
  findings.push_back(encoder_edges(measure_wake_ups(wake_ups)));
  return findings;
}

}  // namespace roadbalance

#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "common/record/disk.hpp"
#include "common/record/test/simulated_folder.hpp"

namespace roadbalance::test {

enum class DiskCall {
  kOpen,
  kClose,
  kWrite,
  kRead,
  kSyncData,
  kSync,
  kTruncate,
  kReserve,
  kSize,
  kLock,
  kRename,
  kUnlink,
  kMakeFolder,
  kList,
  kFreeBytes,
  kIdentity,
};

/// A disk in memory with a page cache and a platter, that fails, fills up, stalls and loses power as set.
///
/// Data and names that were not synced may be lost or torn by a power cut (see SimulatedFile and
/// SimulatedFolder).  One seed and the same calls give the same disk.  Paths are compared as written, from
/// the root; "/" is there, and a relative path lies in it.  For one thread.
///
/// The content of a file costs memory until it is unlinked and its name's folder synced.
class SimulatedDisk final : public Disk {
 public:
  explicit SimulatedDisk(std::uint64_t seed = 1);
  ~SimulatedDisk() override;

  /// The outcome of one call.
  struct Outcome {
    int error = 0;             ///< errno; 0: it is done
    bool short_write = false;  ///< of a write: half of it is done
    bool power_cut = false;    ///< the power goes before the call is done
  };
  /// Asked at every call: its kind, its number from 1, and the path of the file or folder.
  using Fault = std::function<Outcome(DiskCall call, std::int64_t number, const std::string& path)>;
  void set_fault(Fault fault) { fault_ = std::move(fault); }
  /// A fault for one call alone.
  static Fault at_call(std::int64_t number, Outcome outcome);
  std::int64_t calls() const { return calls_; }

  /// How long a call takes, and of all calls until now: the owner of the simulated time adds what is new.
  using Cost = std::function<std::chrono::nanoseconds(DiskCall call, std::size_t bytes)>;
  void set_cost(Cost cost) { cost_ = std::move(cost); }
  std::chrono::nanoseconds busy() const { return busy_; }

  std::size_t open_files() const { return descriptors_.size(); }

  void set_capacity(std::int64_t bytes) { capacity_bytes_ = bytes; }
  std::int64_t used_bytes() const { return *used_bytes_; }
  void set_read_only(bool read_only) { read_only_ = read_only; }

  /// The process that used the disk was killed: its descriptors and locks are gone, the page cache stays. The
  /// rest of it may go on calling; every call on an old descriptor fails (EBADF).
  void kill();
  /// Every call fails (EIO) until power_on(), which shows what the platter has.
  void cut_power();
  bool is_off() const { return off_; }
  /// That all power cuts left in files as they had been, or as whatever lay there, though they were written.
  std::int64_t torn_sectors() const { return torn_sectors_; }
  void power_on() { off_ = false; }

  /// At a folder that there is, another disk, empty the first time; what the folder holds lies beneath.  It
  /// has the room of this one, and a new number the first time.
  void mount(const std::string& folder);
  /// Plugged in anew: a new number, and what is still open of it is not it.
  void plug_in(const std::string& folder);
  /// Another disk, empty, that gets the number of the one that was there, as soon as nothing is open of that.
  void replace(const std::string& folder);
  /// Files that are open of it stay so, as with MNT_DETACH.
  void unmount(const std::string& folder) { mounted_.at(folder).is_there = false; }
  /// Data that were not synced may be lost; nothing that is open of it works any more (EIO).
  void pull_out(const std::string& folder);

  /// For tests, past all faults and costs; an empty one if there is no such file.
  std::vector<std::uint8_t> content(const std::string& path) const;
  /// Puts a file there, synced with its name.  Its folder must exist.
  void put(const std::string& path, const std::vector<std::uint8_t>& bytes);
  /// A sector of a file, the one with this byte, that can never be read again (EIO).
  void spoil(const std::string& path, std::uint64_t offset) { spoilt_.emplace(path, offset); }
  /// Alters one bit of a file, unnoticed.
  void flip_bit(const std::string& path, std::uint64_t bit);

  int open(const char* path, int flags, mode_t mode) override;
  int close(int file) override;
  ssize_t write(int file, const void* bytes, std::size_t size) override;
  ssize_t pwrite(int file, const void* bytes, std::size_t size, off_t offset) override;
  ssize_t pread(int file, void* bytes, std::size_t size, off_t offset) override;
  int fdatasync(int file) override { return sync(DiskCall::kSyncData, file); }
  int fsync(int file) override { return sync(DiskCall::kSync, file); }
  int ftruncate(int file, off_t size) override;
  int fallocate(int file, int mode, off_t offset, off_t size) override;
  int fadvise(int, off_t, off_t, int) override { return 0; }  // advice may be passed over
  off_t size(int file) override;
  int flock(int file, int operation) override;
  int rename(const char* from, const char* to) override;
  int unlink(const char* path) override;
  int mkdir(const char* path, mode_t mode) override;
  std::optional<std::vector<std::string>> list(const char* folder) override;
  std::int64_t free_bytes(const char* folder) override;
  std::optional<FileIdentity> identity(const char* path) override;
  std::optional<FileIdentity> identity(int file) override;

 private:
  using Node = SimulatedFolder::Node;
  struct Descriptor {
    Node node;
    std::string path;
    std::int64_t device = 0;
    std::uint64_t offset = 0;
    bool writes = false;
    bool appends = false;
  };
  struct Place {
    SimulatedFolder* folder = nullptr;  // nullptr: there is no such folder
    std::string name;                   // empty: the root itself
    std::string path;                   // the root's is empty
    std::int64_t device = 1;            // of the folder
  };
  struct Mounted {
    Node root;
    std::int64_t device = 0;
    bool is_there = false;
  };

  bool begins(DiskCall call, const std::string& path, std::size_t bytes, bool changes,
              Outcome* outcome = nullptr);
  Descriptor* descriptor(int file);
  Place place(const std::string& path) const;
  Node find(const std::string& path) const;
  Node enter(Place& at) const;
  bool has_space(const SimulatedFile& file, std::uint64_t size) const;
  int sync(DiskCall call, int file);
  void forget_locks(int file, const Node& node);

  std::mt19937_64 random_;
  std::shared_ptr<std::int64_t> used_bytes_ = std::make_shared<std::int64_t>(0);
  Node root_;
  std::map<std::string, Mounted> mounted_;  // by path
  std::int64_t last_device_ = 1;
  std::set<std::int64_t> pulled_out_;  // devices
  std::map<int, Descriptor> descriptors_;
  int next_descriptor_ = 3;  // never used twice, so that a killed process cannot close another's

  Fault fault_;
  Cost cost_;
  std::int64_t calls_ = 0;
  int kills_ = 0;
  std::chrono::nanoseconds busy_{0};
  std::int64_t capacity_bytes_ = std::numeric_limits<std::int64_t>::max() / 2;
  bool read_only_ = false;
  bool off_ = false;
  std::int64_t torn_sectors_ = 0;
  std::set<std::pair<std::string, std::uint64_t>> spoilt_;  // file, and a byte of the sector
};

}  // namespace roadbalance::test

#include "host/recording/transfer/transfer.hpp"

#include <algorithm>
#include <set>
#include <span>
#include <stdexcept>
#include <system_error>

#include "common/record/failure_words.hpp"
#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "common/record/new_name.hpp"
#include "common/record/record_folder.hpp"
#include "common/record/room.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
// An unplugged disk loses no more than this.
constexpr std::uint64_t kSyncBytes = std::uint64_t{64} << 20;

struct Stopped : std::runtime_error {
  Stopped() : std::runtime_error("stopped") {}
};

class Transfer {
 public:
  Transfer(const fs::path& from, const fs::path& to, const std::stop_token& stop,
           const TransferProgress& progress, Disk& from_disk, Disk& to_disk)
      : from_(from),
        goal_(to / name_of_folder(from)),
        part_(goal_.string() + ".part"),
        stop_(stop),
        progress_(progress),
        from_disk_(from_disk),
        to_disk_(to_disk) {}

  TransferReport run() {
    const File original = claim();
    // Without a mounted disk, a folder made here would lie on the wrong one.
    if (!is_folder(goal_.parent_path(), to_disk_))
      throw std::runtime_error(goal_.parent_path().string() + ": there is no such folder to take it to");
    list();
    if (path_exists(goal_, to_disk_)) {
      compare_with_goal();
    } else {
      expect_new_name(goal_, to_disk_);
      make_goal();
    }
    report_.to = goal_;
    return std::move(report_);
  }

 private:
  File claim() const {
    if (segment_numbers(from_, from_disk_).empty())
      throw std::runtime_error(from_.string() + ": no recording (no segment in it)");
    return hold_at_rest(from_, "transfer it", from_disk_);
  }

  void list() {
    std::vector<std::string> names = list_folder(from_, from_disk_);
    std::erase(names, kDigestsFile);
    std::ranges::sort(names);
    for (const std::string& name : names) {
      // A pipe would wait for a program at its other end, a link would bring a foreign file into the copy.
      if (const std::string kind = irregular_kind(from_ / name); !kind.empty())
        throw std::runtime_error((from_ / name).string() + ": " + kind +
                                 ", which no recording has; move it away");
      if (is_folder(from_ / name, from_disk_))
        throw std::runtime_error((from_ / name).string() +
                                 ": a folder, which no recording has; move it away");
      report_.file.push_back({.name = name, .bytes = size_of_file(from_ / name, from_disk_)});
      report_.bytes += report_.file.back().bytes;
    }
  }

  void compare_with_goal() {
    report_.was_there = true;
    File copy = File::open_folder(goal_, to_disk_);
    if (!copy.try_lock())
      throw std::runtime_error(goal_.string() + ": is the recording itself, or somebody writes to it");
    expect_no_others_in(goal_);
    for (TransferredFile& file : report_.file) {
      file.digest = digest_of(from_ / file.name, from_disk_);
      if (!path_exists(goal_ / file.name, to_disk_) || digest_of(goal_ / file.name, to_disk_) != file.digest)
        throw std::runtime_error(goal_.string() + ": is there already and has another " + file.name +
                                 " than " + from_.string());
    }
  }

  void make_goal() {
    const std::string hint = "; what is there stays in " + part_.string() + ", and the same command goes on";
    try {
      copy_to_part();
      keep();
    } catch (const std::system_error& error) {
      throw std::runtime_error(failure_words(error) + hint);
    } catch (const Stopped&) {
      throw std::runtime_error("stopped" + hint);
    }
  }

  void copy_to_part() {
    create_folders(part_, to_disk_);
    expect_no_others_in(part_);
    expect_space();
    for (TransferredFile& file : report_.file) copy(file);
    sync_folder(part_, to_disk_);
    for (const TransferredFile& file : report_.file)
      if (digest_of(part_ / file.name, to_disk_) != file.digest)
        throw std::runtime_error(
            (part_ / file.name).string() +
            ": reads back otherwise than it was written: this disk is not to be trusted");
  }

  void expect_no_others_in(const fs::path& copy) const {
    std::set<std::string> known{kDigestsFile, std::string(kDigestsFile) + ".new"};
    for (const TransferredFile& file : report_.file) known.insert(file.name);
    for (const std::string& name : list_folder(copy, to_disk_))
      if (!known.contains(name))
        throw std::runtime_error((copy / name).string() + ": is not in " + from_.string() +
                                 "; this is another recording's copy");
  }

  void expect_space() const {
    std::uint64_t needed = 0;
    for (const TransferredFile& file : report_.file) {
      const fs::path copy = part_ / file.name;
      const std::uint64_t there = path_exists(copy, to_disk_) ? size_of_file(copy, to_disk_) : 0;
      needed += file.bytes - std::min(file.bytes, there);
    }
    expect_room(goal_.parent_path(), needed, to_disk_);
  }

  // Bytes behind the last sync of an unplugged disk may be anything: only bytes that compare equal count.
  void copy(TransferredFile& file) {
    const File original = File::open_segment(from_ / file.name, from_disk_);
    const fs::path path = part_ / file.name;
    bool equal = path_exists(path, to_disk_);
    const File before = equal ? File::open_segment(path, to_disk_) : File();  // before a link is written to
    File copy = equal ? File::open_to_write(path, to_disk_) : File::create(path, to_disk_);
    DigestOfBytes digest;
    std::uint64_t offset = 0, unsynced = 0;
    for (auto chunk = read(original, offset); !chunk.empty(); chunk = read(original, offset)) {
      digest.add(chunk);
      equal = equal && is_at(before, offset, chunk);
      if (equal) {
        report_.resumed_bytes += chunk.size();
      } else {
        copy.write_all_at(offset, chunk);
        unsynced += chunk.size();
      }
      offset += chunk.size();
      if (unsynced >= kSyncBytes) {
        copy.sync_data();
        unsynced = 0;
      }
    }
    if (offset != file.bytes)
      throw std::runtime_error((from_ / file.name).string() + ": has changed while it was copied");
    if (copy.size() > offset) copy.truncate(offset);
    copy.sync();
    copy.close();
    file.digest = digest.end();
  }

  bool is_at(const File& file, std::uint64_t offset, std::span<const std::uint8_t> bytes) {
    compared_.resize(bytes.size());
    return file.read_at(offset, compared_) == bytes.size() && std::ranges::equal(compared_, bytes);
  }

  Digest digest_of(const fs::path& path, Disk& disk) {
    const File file = File::open_segment(path, disk);
    file.forget_cache();
    DigestOfBytes digest;
    std::uint64_t offset = 0;
    for (auto chunk = read(file, offset); !chunk.empty(); chunk = read(file, offset)) {
      digest.add(chunk);
      offset += chunk.size();
    }
    return digest.end();
  }

  // All bytes are read once here and once there.
  std::span<const std::uint8_t> read(const File& file, std::uint64_t offset) {
    if (stop_.stop_requested()) throw Stopped();
    chunk_.resize(kChunkBytes);
    const std::span<const std::uint8_t> got = std::span(chunk_).first(file.read_at(offset, chunk_));
    done_ += got.size();
    if (progress_) progress_(done_, 2 * report_.bytes);
    return got;
  }

  void keep() {
    std::string digests;
    for (const TransferredFile& file : report_.file)
      digests += hexadecimal(file.digest) + "  " + file.name + "\n";
    write_atomically(part_ / kDigestsFile, digests, to_disk_);
    rename_file(part_, goal_, to_disk_);
    sync_folder(folder_of(goal_), to_disk_);
  }

  const fs::path from_, goal_, part_;
  const std::stop_token& stop_;
  const TransferProgress& progress_;
  Disk& from_disk_;
  Disk& to_disk_;
  TransferReport report_;
  std::vector<std::uint8_t> chunk_, compared_;
  std::uint64_t done_ = 0;
};

}  // namespace

TransferReport transfer(const fs::path& from, const fs::path& to, const std::stop_token& stop,
                        const TransferProgress& progress, Disk& from_disk, Disk& to_disk) {
  return Transfer(from, to, stop, progress, from_disk, to_disk).run();
}

}  // namespace roadbalance

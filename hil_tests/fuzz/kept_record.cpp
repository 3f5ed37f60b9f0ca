#include "hil_tests/fuzz/kept_record.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "host/recorder/recording_store.hpp"

namespace roadbalance::fuzz {
namespace {

using test::SimulatedDisk;

constexpr std::array<TrueNode, 2> kNodes{{{1, 5, 40}, {2, -6, 25}}};
constexpr std::uint64_t kSegmentBytes = 24 << 10;  // of which a segment's own description takes 14
constexpr int kMostSteps = 32;

// Blocks of each node, by sequence - 1.
const std::vector<SealedBlock>& blocks_of(std::size_t which) {
  static const auto all = [] {
    std::array<std::vector<SealedBlock>, kNodes.size()> blocks;
    for (std::size_t n = 0; n < kNodes.size(); ++n)
      for (std::int64_t k = 1; k <= kNodes[n].last; ++k) blocks[n].push_back(kNodes[n].block(k));
    return blocks;
  }();
  return all[which];
}

class Recorder {
 public:
  explicit Recorder(SimulatedDisk& disk) : disk_(disk) { start(); }

  void append(std::size_t node, std::int64_t count) {
    const auto& blocks = blocks_of(node);
    auto& next = next_[node];
    for (; count > 0 && next < blocks.size(); --count) store_->append(blocks[next++], now_);
  }
  void mark() { store_->note(NoteKind::kMark, ++marks_, 0, "bridge"); }
  void clock() {
    ClockExchange exchange{.node = 1, .epoch = 5, .number = ++exchanges_};
    exchange.heard_ns = exchange.asked_ns = 1000 * exchanges_;
    store_->append(RecordEvent{clock_exchange_channel(1), encode(exchange)}, now_);
  }
  void commit() {
    now_ += std::chrono::seconds(1);
    note(store_->commit(now_));
    store_->maintain();
  }
  void kill(bool power) {
    if (power) disk_.cut_power();
    disk_.kill();
    store_.reset();
    disk_.power_on();
  }
  void start() {
    store_.emplace(disk_, StoreOptions{.folder = KeptRecord::kFolder,
                                       .segment_bytes = kSegmentBytes,
                                       .reserve_bytes = 0,
                                       .ballast_bytes = 0});
    store_->set_clocks(1'790'000'000'000'000, 0);
    store_->begin();
    for (std::size_t n = 0; n < kNodes.size(); ++n) {
      const auto known = store_->recovered().epoch.find({kNodes[n].node, kNodes[n].epoch});
      next_[n] = known == store_->recovered().epoch.end()
                     ? 0
                     : static_cast<std::size_t>(known->second.position.contiguous);
    }
  }
  void close() {
    now_ += std::chrono::seconds(1);
    note(store_->close(now_));
    store_.reset();
  }
  const Sequences& durable() const { return durable_; }
  bool has_all() const {
    for (std::size_t n = 0; n < kNodes.size(); ++n)
      if (next_[n] > 0 && next_[n] < blocks_of(n).size()) return false;
    return true;
  }

 private:
  void note(const std::vector<DurableMark>& marks) {
    for (const DurableMark& mark : marks)
      for (std::int64_t k = 1; k <= mark.sequence; ++k) durable_[{mark.node, mark.epoch}].insert(k);
  }

  SimulatedDisk& disk_;
  std::optional<RecordingStore> store_;
  WallTime now_{std::chrono::hours(1)};
  std::array<std::size_t, kNodes.size()> next_{};
  Sequences durable_;
  std::int64_t marks_ = 0, exchanges_ = 0;
};

}  // namespace

KeptRecord KeptRecord::make(ByteReader& in, SimulatedDisk& disk) {
  Recorder recorder(disk);
  const std::uint8_t end = in.byte();
  for (int steps = end % kMostSteps; steps > 0; --steps) {
    const std::uint8_t what = in.byte();
    switch (what % 8) {
      case 4:
        recorder.mark();
        break;
      case 5:
        recorder.clock();
        break;
      case 6:
        recorder.commit();
        break;
      case 7:
        recorder.kill(what & 8);
        recorder.start();
        break;
      default:
        recorder.append(what >> 3 & 1, 1 + (what >> 4));
    }
  }
  KeptRecord kept;
  kept.closed = end < 192;
  if (kept.closed)
    recorder.close();
  else
    recorder.kill(end & 1);
  kept.durable = recorder.durable();
  kept.has_all = recorder.has_all();
  return kept;
}

const SealedBlock* kept_block(const BlockHeader& header) {
  for (std::size_t n = 0; n < kNodes.size(); ++n)
    if (kNodes[n].node == header.node && kNodes[n].epoch == header.epoch && header.sequence >= 1 &&
        header.sequence <= kNodes[n].last)
      return &blocks_of(n)[static_cast<std::size_t>(header.sequence - 1)];
  return nullptr;
}

int damage_files(const char* folder, ByteReader& in, SimulatedDisk& disk) {
  int times = 0;
  for (; !in.empty() && times < 8; ++times) {
    auto names = *disk.list(folder);
    if (names.empty()) break;
    std::ranges::sort(names);
    const std::uint8_t what = in.byte();
    const std::string path = std::string(folder) + "/" + names[in.byte() % names.size()];
    auto bytes = disk.content(path);
    if (what % 16 == 15) {
      disk.unlink(path.c_str());
      continue;
    }
    if (bytes.empty()) continue;
    const auto at = static_cast<std::size_t>(in.number(2)) % bytes.size();
    const auto from = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    if (what % 16 < 8) {
      bytes[at] ^= static_cast<std::uint8_t>(1 << what % 8);
    } else if (what % 16 < 10) {
      bytes.resize(at);
    } else if (what % 16 < 12) {
      bytes.erase(from, from + std::min<std::ptrdiff_t>(in.byte(), bytes.end() - from));
    } else if (what % 16 < 14) {
      const auto more = in.take(in.byte());
      bytes.insert(from, more.begin(), more.end());
    } else {
      const std::vector<std::uint8_t> twice(
          from, from + std::min<std::ptrdiff_t>(in.number(2) % 4096, bytes.end() - from));
      bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(in.number(2) % bytes.size()), twice.begin(),
                   twice.end());
    }
    disk.put(path, bytes);
  }
  return times;
}

}  // namespace roadbalance::fuzz

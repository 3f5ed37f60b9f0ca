#include "host/recorder/write.hpp"

#include <map>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/clock/clocks.hpp"
#include "host/recorder/manifest.hpp"
#include "host/recorder/preamble.hpp"

namespace roadbalance {
namespace {

// At the highest rates a commit begins as soon as the one before is over: this many blocks are worth one.
constexpr std::int64_t kBlocksWorthACommit = 512;

std::int64_t unix_time_us() {
  using namespace std::chrono;
  return duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
}

class Writer {
 public:
  Writer(const WriteOptions& options, RecordWriter record,
         std::map<NodeEpoch, std::vector<SealedBlock>> vehicle)
      : options_(options), record_(std::move(record)), vehicle_(std::move(vehicle)) {
    record_.set_preamble(make_preamble(vehicle_));
  }

  void append(const Delivery& delivery) {
    SealedBlock declared;
    const auto* block = std::get_if<SealedBlock>(&delivery);
    if (!block) {
      seal(std::get<GapBlock>(delivery), declared);
      block = &declared;
    }
    if (pending_.empty()) oldest_ = WallClock::now();
    record_.append(block_channel(block->header.node, block->kind), block->bytes(), unix_time_us());
    ++blocks_;
    urgent_ = urgent_ || block->kind == BlockKind::kEnd;
    const NodeEpoch key{block->header.node, block->header.epoch};
    pending_[key] = block->header.sequence;
    if (block->kind == BlockKind::kMeta && decode_meta(*block).kind == MetaKind::kVehicleToml) {
      vehicle_[key].push_back(*block);
      record_.set_preamble(make_preamble(vehicle_));
    }
  }

  bool commit_is_due() const {
    return !pending_.empty() && (urgent_ || blocks_ >= kBlocksWorthACommit || time_left().count() <= 0);
  }

  std::chrono::milliseconds time_left() const {
    if (pending_.empty()) return options_.commit_period;
    return std::chrono::ceil<std::chrono::milliseconds>(oldest_ + options_.commit_period - WallClock::now());
  }

  std::vector<DurableMark> commit() {
    record_.sync();
    if (record_.segment() > listed_ + 1) {
      listed_ = record_.segment() - 1;
      write_manifest(options_.folder, listed_);
    }
    std::vector<DurableMark> marks;
    for (const auto& [key, sequence] : pending_) marks.push_back({key.first, key.second, sequence});
    pending_.clear();
    blocks_ = 0;
    urgent_ = false;
    return marks;
  }

  void close() {
    record_.close();
    write_manifest(options_.folder);
  }

 private:
  const WriteOptions options_;
  RecordWriter record_;
  std::map<NodeEpoch, std::vector<SealedBlock>> vehicle_;
  std::map<NodeEpoch, std::int64_t> pending_;  // appended, not committed
  WallTime oldest_{};
  std::int64_t blocks_ = 0;
  bool urgent_ = false;
  int listed_ = 0;  // last segment that the manifest lists as finished
};

}  // namespace

void write_record(const WriteOptions& options, RecordWriter record,
                  std::map<NodeEpoch, std::vector<SealedBlock>> vehicle, In<std::vector<Delivery>> deliveries,
                  Out<std::vector<DurableMark>> durable) {
  Writer writer(options, std::move(record), std::move(vehicle));
  std::vector<DurableMark> unsent;  // never waits for the reader, who may be waiting for us
  while (!deliveries.finished()) {
    if (const auto batch = deliveries.receive_for(writer.time_left()))
      for (const auto& delivery : *batch) writer.append(delivery);
    if (writer.commit_is_due())
      for (const auto& mark : writer.commit()) unsent.push_back(mark);
    if (!unsent.empty() && durable.try_send(unsent)) unsent.clear();
  }
  writer.commit();
  writer.close();
}

}  // namespace roadbalance

#include "firmware/epoch_packer.hpp"

#include <exception>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "firmware/block_packer.hpp"

namespace roadbalance {

struct EpochPacker::State {
  /// Hands over each block as it is committed; an exception of the taker waits until the packer has
  /// returned.
  class TakingSink final : public BlockSink {
   public:
    explicit TakingSink(EpochPacker::Take take) : take_(std::move(take)) {}

    std::size_t room() const noexcept override { return std::numeric_limits<std::size_t>::max(); }
    SealedBlock* claim() noexcept override { return &block_; }
    void commit() noexcept override {
      if (failure_) return;
      try {
        take_(block_);
      } catch (...) {
        failure_ = std::current_exception();
      }
    }
    void rethrow() const {
      if (failure_) std::rethrow_exception(failure_);
    }

   private:
    const EpochPacker::Take take_;
    SealedBlock block_;
    std::exception_ptr failure_;
  };

  State(const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch, Take take, GapCause jump)
      : sink(std::move(take)), packer(vehicle, node, epoch, sink, nullptr, jump) {}
  TakingSink sink;
  BlockPacker packer;
};

EpochPacker::EpochPacker(const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch, Take take,
                         GapCause jump)
    : state_(std::make_unique<State>(vehicle, node, epoch, std::move(take), jump)) {
  state_->packer.start();
  state_->sink.rethrow();
}

EpochPacker::~EpochPacker() = default;

void EpochPacker::begin_at(std::int64_t index, NodeTime time) {
  state_->packer.begin_at(index, time);
}

void EpochPacker::end_at(std::int64_t index, NodeTime time) {
  state_->packer.end_at(index, time);
}

void EpochPacker::add(std::span<const Scan> scans, std::span<const Edge> edges,
                      std::span<const SignalSample> signals, bool more_edges) {
  state_->packer.add(signals);
  state_->packer.add(scans, edges, more_edges);
  state_->sink.rethrow();
}

std::array<int, 2> EpochPacker::mark_counts(int line) const {
  return state_->packer.encoder_faults(line).mark_counts;
}

void EpochPacker::end() {
  state_->packer.device_ended();
  static_cast<void>(state_->packer.finish());  // this sink always takes it
  state_->sink.rethrow();
}

void pack_epoch(FrontEnd& front_end, const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch,
                const EpochPacker::Take& take, GapCause jump) {
  EpochPacker packer(vehicle, node, epoch, take, jump);
  std::vector<Scan> scans(64);
  std::vector<Edge> edges(4096);
  std::vector<SignalSample> signals(1024);
  for (Read read; read.status == ReadStatus::kOk;) {
    read = front_end.read(scans, edges, signals);
    packer.add(std::span(scans).first(read.scans), std::span(edges).first(read.edges),
               std::span(signals).first(read.signals), read.edges == edges.size());
    if (read.status == ReadStatus::kFailed)
      throw std::runtime_error("front end of node " + node.name + " failed");
  }
  packer.end();
}

}  // namespace roadbalance

#include "firmware/seal_all.hpp"

#include <exception>
#include <limits>
#include <stdexcept>
#include <vector>

#include "firmware/pack.hpp"

namespace roadbalance {

namespace {

/// Hands over each block as it is committed; an exception of the taker waits until the sealer has returned.
class TakingSink final : public BlockSink {
 public:
  explicit TakingSink(const std::function<void(const SealedBlock&)>& take) : take_(take) {}

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
  const std::function<void(const SealedBlock&)>& take_;
  SealedBlock block_;
  std::exception_ptr failure_;
};

}  // namespace

void seal_all(FrontEnd& front_end, const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch,
              const std::function<void(const SealedBlock&)>& take, GapCause jump) {
  TakingSink sink(take);
  Sealer sealer(vehicle, node, epoch, sink, nullptr, jump);
  std::vector<Scan> scans(64);
  std::vector<Edge> edges(4096);
  std::vector<SignalSample> signals(1024);
  sealer.start();
  for (Read read; read.status == ReadStatus::kOk; sink.rethrow()) {
    read = front_end.read(scans, edges, signals);
    sealer.add(std::span(signals).first(read.signals));
    sealer.add(std::span(scans).first(read.scans), std::span(edges).first(read.edges),
               read.edges == edges.size());
    if (read.status == ReadStatus::kFailed)
      throw std::runtime_error("front end of node " + node.name + " failed");
  }
  sealer.device_ended();
  static_cast<void>(sealer.finish());  // this sink always takes it
  sink.rethrow();
}

}  // namespace roadbalance

#include "host/analyser/live_view.hpp"

#include <chrono>
#include <map>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/results.hpp"
#include "common/clock/clocks.hpp"
#include "host/analyser/levels.hpp"
#include "host/analyser/spectra.hpp"
#include "host/analyser/transfer_view.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kLevelInterval{100};
constexpr std::chrono::milliseconds kSpectrumInterval{1000};

struct NodeView {
  LevelMeter levels;
  SpectrumMeter spectra;
  std::int64_t epoch = 0;
  std::int64_t last_sequence = 0;
  std::int64_t skipped = 0;

  /// True if the block is new to this view; counts those that were not seen.
  bool admit(const BlockHeader& header) {
    if (header.sequence == 0) return true;  // preview
    if (header.epoch != epoch) {
      epoch = header.epoch;
      last_sequence = header.sequence - 1;  // what was before this view began was not skipped
    }
    if (header.sequence <= last_sequence) return false;  // repaired for the recorder
    skipped += header.sequence - last_sequence - 1;
    last_sequence = header.sequence;
    return true;
  }
};

class LiveView {
 public:
  LiveView(const std::string& url, const VehicleConfig& vehicle) : bus_(url), transfers_(vehicle) {
    for (const auto& node : vehicle.node)
      nodes_.emplace(node.id, NodeView{LevelMeter(vehicle, node), SpectrumMeter(node)});
    const auto take = [this](std::string_view, std::span<const std::uint8_t> bytes) { add(bytes); };
    bus_.subscribe("RB_BLOCK_.*", take);
    bus_.subscribe("RB_PREVIEW_.*", take);
    bus_.subscribe("RB_CLOCK_.*", [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto fit = decode_clock_fit(bytes)) transfers_.consume(*fit);
    });
    bus_.subscribe(kViewChannel, [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto view = decode_view(bytes)) transfers_.take(*view, WallClock::now());
    });
  }

  void step() {
    bus_.handle(std::chrono::milliseconds(20));
    const WallTime now = WallClock::now();
    if (now - levels_published_ >= kLevelInterval) {
      levels_published_ = now;
      for (auto& [id, node] : nodes_)
        if (auto level = node.levels.take()) {
          level->skipped = node.skipped;
          bus_.publish(kLevelChannel, encode(*level));
        }
      for (const TransferPart& part : transfers_.parts(WallClock::now()))
        bus_.publish(kTransferChannel, encode(part));
    }
    if (now - spectra_published_ >= kSpectrumInterval) {
      spectra_published_ = now;
      for (auto& [id, node] : nodes_)
        for (const auto& part : node.spectra.take()) bus_.publish(kSpectrumChannel, encode(part));
    }
  }

  std::vector<std::string> other_versions() { return bus_.other_versions(); }

 private:
  void add(std::span<const std::uint8_t> bytes) {
    if (accept(bytes, *block_) != Refusal::kNone) return;
    const auto node = nodes_.find(block_->header.node);
    if (node == nodes_.end() || !node->second.admit(block_->header) || block_->kind != BlockKind::kScan)
      return;
    const ScanBlock scans = decode_scan(*block_);
    node->second.levels.add(scans);
    node->second.spectra.add(scans);
    if (block_->header.sequence != 0) transfers_.consume(*block_);  // no preview: it skips
  }

  Bus bus_;
  std::map<std::int32_t, NodeView> nodes_;
  TransferView transfers_;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
  WallTime levels_published_{};
  WallTime spectra_published_{};
};

}  // namespace

void live_view(std::stop_token stop, const std::string& url, const VehicleConfig& vehicle,
               const std::function<void(const std::string&)>& warn) {
  LiveView view(url, vehicle);
  while (!stop.stop_requested()) {
    view.step();
    for (const std::string& sentence : view.other_versions()) warn(sentence);
  }
}

}  // namespace roadbalance

#include "host/analyser/live_view.hpp"

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/display.hpp"
#include "common/bus/results.hpp"
#include "common/bus/setup.hpp"
#include "common/types/clocks.hpp"
#include "host/analyser/chosen_vehicle.hpp"
#include "host/analyser/sample_beat.hpp"
#include "host/analyser/spectrum_view.hpp"
#include "host/analyser/tap_meter.hpp"
#include "host/analyser/transfer_function_view.hpp"
#include "host/analyser/waterfall_view.hpp"
#include "host/analysis/identify/clipped_channels.hpp"
#include "host/analysis/spectra/channel_watch.hpp"
#include "host/analysis/spectra/envelopes.hpp"
#include "host/analysis/spectra/spectra.hpp"
#include "host/recording/in_sequence.hpp"
#include "host/recording/levels.hpp"

namespace roadbalance {
namespace {

// Periods of what is sent of samples, in their time; of what a viewer asks for, in his.
constexpr double kLevel_s = 0.1, kSpectrum_s = 1.0;
constexpr std::chrono::milliseconds kViewInterval{100};
constexpr std::chrono::milliseconds kEnvelopeInterval{50};
constexpr std::chrono::milliseconds kWaterfallInterval{1000};

/// True if it is time again.
class Every {
 public:
  explicit Every(std::chrono::milliseconds interval) : interval_(interval) {}
  bool due(WallTime now) {
    if (now - last_ < interval_) return false;
    // A late one does not make the next one late; a missed one is not made up for.
    last_ = now - last_ < 2 * interval_ ? last_ + interval_ : now;
    return true;
  }

 private:
  std::chrono::milliseconds interval_;
  WallTime last_{};
};

struct NodeView {
  LevelMeter levels;
  SpectrumMeter spectra;
  EnvelopeMeter envelopes;
  TapMeter taps;
  ClippedChannels clipping;
  std::uint32_t clipped = 0;  ///< since the last level
  SampleBeat level_beat{kLevel_s}, spectrum_beat{kSpectrum_s};
  InSequence sequence{InSequence::From::kFirstHeard};
};

class LiveView {
 public:
  LiveView(const std::string& url, const VehicleConfig& vehicle, const VehicleByCrc& find,
           const std::function<void(const std::string&)>& warn, Out<Ack>& acks)
      : bus_(url, {.ahead_bytes = kAhead}),
        watch_(vehicle),
        transfer_functions_(vehicle),
        spectra_(vehicle),
        waterfalls_(vehicle),
        chosen_(vehicle, find, warn) {
    for (const auto& node : vehicle.node)
      nodes_.emplace(node.id, NodeView{.levels = LevelMeter(vehicle, node),
                                       .spectra = SpectrumMeter(node),
                                       .envelopes = EnvelopeMeter(node),
                                       .taps = TapMeter(node),
                                       .clipping = ClippedChannels(node)});
    const auto take = [this](std::string_view, std::span<const std::uint8_t> bytes) { add(bytes); };
    bus_.subscribe("RB_BLOCK_.*", take);
    bus_.subscribe("RB_PREVIEW_.*", take);
    bus_.subscribe("RB_CLOCK_.*", [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto fit = decode_clock_fit(bytes)) add(*fit);
    });
    bus_.subscribe("RB_SETUP_.*", [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto setup = decode_setup(bytes)) chosen_.take(*setup, WallClock::now());
    });
    bus_.subscribe("RB_ACK_.*", [&acks](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto ack = decode_ack(bytes)) acks.try_send(*ack);
    });
    bus_.subscribe(kViewChannel, [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto view = decode_view(bytes)) add(*view);
    });
  }

  void step() {
    bus_.handle(std::chrono::milliseconds(20));
    const WallTime now = WallClock::now();
    if (views_.due(now)) publish_views(now);
    if (envelopes_.due(now)) publish_envelopes(now);
    if (waterfall_.due(now))
      for (const WaterfallRow& row : waterfalls_.rows(now)) bus_.publish(kWaterfallChannel, encode(row));
  }

  std::vector<std::string> other_versions() { return bus_.other_versions(); }
  std::optional<VehicleConfig> other_vehicle() { return chosen_.changed(WallClock::now()); }

 private:
  void publish_level(NodeView& node) {
    auto level = node.levels.take();
    if (!level) return;
    level->skipped = node.sequence.missing();
    level->clipped = std::exchange(node.clipped, 0);
    watch_.judge(*level);
    bus_.publish(kLevelChannel, encode(*level));
  }

  void publish_views(WallTime now) {
    for (const TransferFunctionPart& part : transfer_functions_.parts(now))
      bus_.publish(kTransferFunctionChannel, encode(part));
    for (const SpectrumPart& part : spectra_.parts(now)) bus_.publish(kSpectrumChannel, encode(part));
  }

  void publish_envelopes(WallTime now) {
    std::erase_if(watched_, [now](const auto& one) { return now - one.second > kForgotten; });
    for (const auto& [channel, heard] : watched_)
      if (const auto node = nodes_.find(channel.node); node != nodes_.end())
        if (const auto envelope = node->second.envelopes.envelope(channel.channel))
          bus_.publish(kEnvelopeChannel, encode(*envelope));
  }

  void add(const View& view) {
    const WallTime now = WallClock::now();
    transfer_functions_.take(view, now);
    spectra_.take(view, now);
    waterfalls_.take(view, now);
    for (const ChannelId& channel : view.envelope)
      if (watched_.contains(channel) || watched_.size() < kMostEnvelopes) watched_[channel] = now;
  }

  void add(const ClockFit& fit) {
    transfer_functions_.consume(fit);
    spectra_.consume(fit);
    waterfalls_.consume(fit);
  }

  void add(std::span<const std::uint8_t> bytes) {
    if (accept(bytes, *block_) != Refusal::kNone) return;
    const auto node = nodes_.find(block_->header.node);
    if (node == nodes_.end()) return;
    if (block_->header.sequence == 0)
      show(node->second, *block_);
    else  // once, though it comes again for the recorder
      node->second.sequence.add(*block_, [&](const SealedBlock& block) { show(node->second, block); });
  }

  void show(NodeView& node, const SealedBlock& block) {
    if (block.kind != BlockKind::kScan) return;
    const ScanBlock scans = decode_scan(block);
    node.levels.add(scans);
    node.clipped |= static_cast<std::uint32_t>(node.clipping.add(scans).reached);
    node.spectra.add(scans);
    const WallTime now = WallClock::now();
    if (node.level_beat.due(scans, now)) publish_level(node);
    if (node.spectrum_beat.due(scans, now))
      for (const SpectrumPart& part : node.spectra.take()) bus_.publish(kSpectrumChannel, encode(part));
    if (const auto tap = node.taps.add(scans)) bus_.publish(kTapChannel, encode(*tap));
    if (block.header.sequence == 0) return;  // a preview skips
    node.envelopes.add(scans);
    transfer_functions_.consume(block);
    spectra_.consume(block);
    waterfalls_.consume(block);
  }

  static constexpr std::chrono::seconds kForgotten{3};
  static constexpr std::size_t kMostEnvelopes = 64;
  /// A drive that is played faster than it can be shown waits: a minute of it at twenty times its speed.
  static constexpr std::size_t kAhead = 512 << 20;

  Bus bus_;
  std::map<std::int32_t, NodeView> nodes_;
  ChannelWatch watch_;
  TransferFunctionView transfer_functions_;
  SpectrumView spectra_;
  WaterfallView waterfalls_;
  std::map<ChannelId, WallTime> watched_;  ///< envelopes that a viewer asks for, and when it did
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
  ChosenVehicle chosen_;
  Every views_{kViewInterval}, envelopes_{kEnvelopeInterval}, waterfall_{kWaterfallInterval};
};

}  // namespace

void live_view(std::stop_token stop, const std::string& url, const VehicleConfig& vehicle,
               const VehicleByCrc& find, const std::function<void(const std::string&)>& warn, Out<Ack> acks) {
  std::optional<LiveView> view(std::in_place, url, vehicle, find, warn, acks);
  while (!stop.stop_requested()) {
    view->step();
    for (const std::string& sentence : view->other_versions()) warn(sentence);
    // A viewer repeats its request within a second.
    if (const auto other = view->other_vehicle()) view.emplace(url, *other, find, warn, acks);
  }
}

}  // namespace roadbalance

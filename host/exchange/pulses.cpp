#include "host/exchange/pulses.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record.hpp"
#include "host/analyser/in_sequence.hpp"
#include "host/exchange/byte_sink.hpp"
#include "host/exchange/decimal_text.hpp"

namespace roadbalance {
namespace {

constexpr std::array kKindNames{"tooth", "zero", "tooth_backward", "lost"};  ///< by EdgeKind

/// The edges of one node, in order of time.
class NodeEdges {
 public:
  NodeEdges(const std::filesystem::path& folder, const VehicleConfig& vehicle, const NodeConfig& node)
      : reader_(folder),
        edge_channel_(block_channel(node.id, BlockKind::kEdge)),
        fit_channel_(clock_fit_channel(node.id)) {
    for (int line = 0; line < kEncoderLines; ++line)
      wheel_[static_cast<std::size_t>(line)] = vehicle.wheel_at(node, line);
    reader_.finish();
    advance();
  }

  bool is_there() const { return at_ < edges_.size(); }
  const Edge& edge() const { return edges_[at_]; }
  /// nullptr: no wheel is on that line.
  const WheelConfig* wheel() const { return edge().line < wheel_.size() ? wheel_[edge().line] : nullptr; }
  /// As the recording tells time.
  std::int64_t time_ns() const {
    const std::int64_t node_ns = to_ns(edge().time);
    const auto fit = fit_.find(epoch_);
    return fit == fit_.end() ? node_ns : fit->second.host_time_ns(node_ns);
  }

  void advance() {
    if (++at_ < edges_.size()) return;
    at_ = 0;
    edges_.clear();
    while (const auto event = reader_.next()) {
      if (event->channel == fit_channel_) {
        const auto fit = decode_clock_fit(event->data);
        if (fit && fit->state != ClockState::kAcquire) fit_[fit->epoch] = *fit;
      }
      if (event->channel != edge_channel_ || accept(event->data, sealed_) != Refusal::kNone ||
          sealed_.kind != BlockKind::kEdge)
        continue;
      in_sequence_.add(sealed_, [&](const SealedBlock& block) { edges_ = decode_edge(block).unpack(); });
      epoch_ = sealed_.header.epoch;
      if (!edges_.empty()) return;
    }
  }

 private:
  RecordReader reader_;
  const std::string edge_channel_, fit_channel_;
  std::array<const WheelConfig*, kEncoderLines> wheel_{};
  std::map<std::int64_t, ClockFit> fit_;  ///< of an epoch, that came last
  InSequence in_sequence_;
  SealedBlock sealed_;
  std::int64_t epoch_ = 0;
  std::vector<Edge> edges_;
  std::size_t at_ = 0;
};

}  // namespace

std::int64_t write_pulses(const std::filesystem::path& folder, const VehicleConfig& vehicle,
                          const ExportTable& table, const ExportSelection& selection,
                          const std::filesystem::path& file, const std::stop_token& stop) {
  std::vector<std::unique_ptr<NodeEdges>> nodes;
  for (const auto& node : vehicle.node) nodes.push_back(std::make_unique<NodeEdges>(folder, vehicle, node));
  ByteSink sink(file);
  sink.put("time_s,wheel,kind\n");
  std::int64_t written = 0;
  while (true) {
    std::erase_if(nodes, [](const auto& node) { return !node->is_there(); });
    if (nodes.empty()) break;
    NodeEdges& next = **std::min_element(
        nodes.begin(), nodes.end(), [](const auto& a, const auto& b) { return a->time_ns() < b->time_ns(); });
    const std::int64_t time_ns = next.time_ns() - table.start_ns;
    const double seconds = static_cast<double>(time_ns) * 1e-9;
    if (next.wheel() != nullptr && seconds >= selection.from_s &&
        (!selection.to_s || seconds < *selection.to_s)) {
      std::array<char, kDecimalText> text;
      const char* end = write_decimal(text.data(), time_ns, 9);
      sink.put(std::string_view(text.data(), static_cast<std::size_t>(end - text.data())));
      sink.put("," + next.wheel()->name + "," + kKindNames[static_cast<std::size_t>(next.edge().kind)] +
               "\n");
      if ((++written & 0xFFFF) == 0 && stop.stop_requested()) throw std::runtime_error("stopped");
    }
    next.advance();
  }
  sink.close();
  return written;
}

}  // namespace roadbalance

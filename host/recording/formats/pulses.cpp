#include "host/recording/formats/pulses.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record_reader.hpp"
#include "host/recording/formats/byte_sink.hpp"
#include "host/recording/formats/decimal_text.hpp"
#include "host/recording/formats/epoch_clock.hpp"
#include "host/recording/in_sequence.hpp"

namespace roadbalance {
namespace {

/// The edges of one node epoch, in order of time.  Edges that came late (repaired after an hour without a
/// network) stand behind later ones in the recording: so each epoch has a reader.
class EpochEdges {
 public:
  EpochEdges(const std::filesystem::path& folder, const RecordingSurvey& survey, const NodeConfig& node,
             const RecordedSpan& span)
      : reader_(folder),
        key_(span.node, span.epoch),
        edge_channel_(block_channel(span.node, BlockKind::kEdge)),
        clock_(key_, span.first_fit, survey.own_clocks()) {
    for (int line = 0; line < kEncoderLines; ++line)
      wheel_[static_cast<std::size_t>(line)] = survey.vehicle.wheel_at(node, line);
    reader_.finish();
    advance();
  }

  bool is_there() const { return at_ < edges_.size(); }
  const Edge& edge() const { return edges_[at_]; }
  const WheelConfig& wheel() const { return *wheel_[edge().line]; }
  /// Time on the recording's clock.  It never steps back, although fits of a clock differ by microseconds.
  std::int64_t time_ns() const { return time_ns_; }
  /// Edges so far whose time is unknown.
  std::int64_t left_out() const { return left_out_; }

  void advance() {
    do ++at_;
    while ((at_ < edges_.size() || read()) && !place());
  }

 private:
  /// False if no wheel is on that line, or the time of the edge is unknown.
  bool place() {
    if (edge().line >= wheel_.size() || wheel_[edge().line] == nullptr) return false;
    const auto time_ns = clock_.time_ns(to_ns(edge().time));
    if (time_ns)
      time_ns_ = std::max(time_ns_, *time_ns);
    else
      ++left_out_;
    return time_ns.has_value();
  }

  bool read() {
    at_ = 0;
    edges_.clear();
    while (const auto event = reader_.next()) {
      clock_.take(*event);
      if (event->channel != edge_channel_ || accept(*event, sealed_) != Refusal::kNone ||
          sealed_.kind != BlockKind::kEdge || NodeEpoch{sealed_.header.node, sealed_.header.epoch} != key_)
        continue;
      in_sequence_.add(sealed_, [&](const SealedBlock& block) { edges_ = decode_edge(block).unpack(); });
      if (!edges_.empty()) return true;
    }
    return false;
  }

  RecordReader reader_;
  const NodeEpoch key_;
  const std::string edge_channel_;
  EpochClock clock_;
  std::array<const WheelConfig*, kEncoderLines> wheel_{};  ///< nullptr: none is on that line
  InSequence in_sequence_;
  SealedBlock sealed_;
  std::vector<Edge> edges_;
  std::size_t at_ = 0;
  std::int64_t time_ns_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t left_out_ = 0;
};

}  // namespace

WrittenPulses write_pulses(const std::filesystem::path& folder, const RecordingSurvey& survey,
                           const ExportTable& table, const ExportSelection& selection,
                           const std::filesystem::path& file, const std::stop_token& stop) {
  std::vector<std::unique_ptr<EpochEdges>> epochs;
  for (const auto& node : survey.vehicle.node)  // nodes keep this order at equal instants
    for (const auto& span : survey.span)
      if (span.node == node.id) epochs.push_back(std::make_unique<EpochEdges>(folder, survey, node, span));
  ByteSink sink(file);
  sink.put("time_s,wheel,kind\n");
  WrittenPulses pulses;
  while (true) {
    std::erase_if(epochs, [&](const auto& epoch) {
      if (!epoch->is_there()) pulses.left_out += epoch->left_out();
      return !epoch->is_there();
    });
    if (epochs.empty()) break;
    EpochEdges& next = **std::min_element(epochs.begin(), epochs.end(), [](const auto& a, const auto& b) {
      return a->time_ns() < b->time_ns();
    });
    const std::int64_t time_ns = next.time_ns() - table.start_ns;
    const double seconds = static_cast<double>(time_ns) * 1e-9;
    if (seconds >= selection.from_s && (!selection.to_s || seconds < *selection.to_s)) {
      std::array<char, kDecimalText> text;
      const char* end = write_decimal(text.data(), time_ns, 9);
      sink.put(std::string_view(text.data(), static_cast<std::size_t>(end - text.data())));
      sink.put("," + next.wheel().name + ",");
      sink.put(kPulseKinds.at(static_cast<std::size_t>(next.edge().kind)));
      sink.put("\n");
      if ((++pulses.written & 0xFFFF) == 0 && stop.stop_requested()) throw std::runtime_error("stopped");
    }
    next.advance();
  }
  sink.close();
  return pulses;
}

}  // namespace roadbalance

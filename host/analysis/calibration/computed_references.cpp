#include "host/analysis/calibration/computed_references.hpp"

#include "common/bus/codec.hpp"

namespace roadbalance {

ComputedReferences::ComputedReferences(const VehicleConfig& vehicle, const NodeConfig& node,
                                       EdgeMemory memory)
    : node_(node.id), filter_(vehicle.filter, node.rate_hz), memory_(memory) {
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    const WheelConfig* const wheel = vehicle.wheel_at(node, static_cast<int>(line));
    if (wheel && wheel->encoder.counter.empty()) encoder_[line] = wheel->encoder;
  }
}

void ComputedReferences::learn(const SealedBlock& block) {
  if (block.kind != BlockKind::kEdge || block.header.node != node_) return;
  for (const Edge& edge : decode_edge(block).unpack())
    if (edge.line < kEncoderLines && encoder_[edge.line]) {
      memory_.add(1);
      edges_[{block.header.epoch, edge.line}].push_back(edge);
    }
}

RecordedAngle* ComputedReferences::angle(std::int64_t epoch, std::size_t line) {
  if (!encoder_[line]) return nullptr;
  auto& made = angles_[{epoch, line}];
  if (!made) {
    auto& edges = edges_[{epoch, line}];
    made = std::make_unique<RecordedAngle>(*encoder_[line], edges);
    edges = {};
  }
  return made.get();
}

const ComputedReferences::Rows& ComputedReferences::of(const ScanBlock& block) {
  const BlockHeader& header = block.header;
  const bool after_jump = header.epoch != epoch_ || header.first_scan != next_scan_;
  epoch_ = header.epoch;
  next_scan_ = header.first_scan + header.scans;
  const auto scans = static_cast<int>(header.scans);
  const NodeTime from = filter_.first_step(node_time_from_ns(header.time_ns));
  ReferenceFilter::Angles known{};
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    RecordedAngle* const of_line = angle(header.epoch, line);
    angle_rad_[line].resize(static_cast<std::size_t>(filter_.steps(scans)));
    if (of_line && of_line->angles(from, filter_.step_ns(), angle_rad_[line])) known[line] = angle_rad_[line];
  }
  rows_.quality =
      filter_.fill(std::span(rows_.counts).first(static_cast<std::size_t>(scans)), known, after_jump);
  return rows_;
}

}  // namespace roadbalance

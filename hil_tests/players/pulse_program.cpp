#include "hil_tests/players/pulse_program.hpp"

#include <algorithm>
#include <utility>

#include "common/config/section.hpp"

namespace roadbalance::test {
namespace {

constexpr NodeClock::duration kLongestPulse = std::chrono::microseconds(100);

}  // namespace

void PulseProgram::add(const NodeDrive& drive, std::uint8_t line, std::uint16_t teeth,
                       std::optional<std::uint16_t> marks) {
  std::vector<NodeTime> tooth, mark;
  for (const Edge& edge : drive.edges) {
    if (edge.line != line) continue;
    if (edge.kind == EdgeKind::kTooth) tooth.push_back(edge.time);
    if (edge.kind == EdgeKind::kZeroMark) mark.push_back(edge.time);
  }
  add(tooth, teeth);
  if (marks) add(mark, *marks);
}

void PulseProgram::add(const std::vector<NodeTime>& rises, std::uint16_t wire) {
  for (std::size_t k = 0; k < rises.size(); ++k) {
    const auto room = k + 1 < rises.size() ? (rises[k + 1] - rises[k]) / 2 : kLongestPulse;
    levels_.push_back({rises[k], wire, true});
    levels_.push_back({rises[k] + std::min(room, kLongestPulse), wire, false});
  }
}

std::vector<DriveLevel> PulseProgram::take() {
  std::ranges::stable_sort(levels_, {}, &DriveLevel::time);
  return std::exchange(levels_, {});
}

void check_playable(const VehicleConfig& vehicle, const NodeConfig& node, const NodeDrive& drive) {
  for (const LineConfig& line : node.wiring.line)
    if (line.direction_gpio)
      throw ConfigError("[[node.line]] line " + std::to_string(line.line) + " of node " + node.name +
                        ": direction_gpio: second tracks are not played");
  for (int line = 0; line < kEncoderLines; ++line)
    if (const WheelConfig* const wheel = vehicle.wheel_at(node, line); wheel && wheel->encoder.quadrature)
      throw ConfigError("wheel " + wheel->name + ": encoder.quadrature: second tracks are not played");
  if (std::ranges::find(drive.edges, EdgeKind::kToothBackward, &Edge::kind) != drive.edges.end())
    throw ConfigError("drive of node " + node.name + ": a wheel turns backwards, which is not played");
}

}  // namespace roadbalance::test

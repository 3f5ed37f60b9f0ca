#include "hil_tests/players/player.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/config/section.hpp"
#include "common/process/parallel.hpp"
#include "common/process/pause.hpp"
#include "firmware/backends/usb/usb_address.hpp"

namespace roadbalance::test {
namespace {

/// A node's address of one kind, e.g. "usb:": the text behind it in its front_end; nothing: none.
std::optional<std::string> address_of(const NodeConfig& node, const std::string& scheme) {
  for (const std::string& uri : node.wiring.front_end)
    if (uri.starts_with(scheme)) return uri.substr(scheme.size());
  return std::nullopt;
}

std::string serial_of(const NodeConfig& node) {
  const auto address = address_of(node, "usb:");
  if (!address)
    throw ConfigError("node " + node.name +
                      ": front_end: has no board, at which its accelerations are played; "
                      "allowed: \"usb:1209:0001:SERIAL\" among them");
  const UsbAddress usb = UsbAddress::parse(*address);
  if (usb.vendor != board::kVendorId || usb.product != board::kProductId || usb.boards() > 1)
    throw ConfigError("node " + node.name + ": front_end: usb:" + *address +
                      " is not played; allowed: one board, usb:1209:0001");
  return usb.serial.empty() ? node.name : usb.serial.front();
}

void check_chip(const NodeConfig& node) {
  const auto chip = address_of(node, "gpio:");
  if (chip && *chip != PulseChip::name())
    throw ConfigError("node " + node.name + ": front_end: gpio:" + *chip +
                      " does not play; allowed: gpio:" + PulseChip::name());
  if (!chip && !node.wiring.line.empty())
    throw ConfigError("node " + node.name + ": has [[node.line]], but no gpio: in its front_end");
}

nlohmann::ordered_json json_of(const Lateness& late) {
  return {{"count", late.count}, {"mean_late_ns", late.mean_ns()}, {"worst_late_ns", late.worst_ns}};
}

}  // namespace

Player::Player(const VehicleConfig& vehicle, std::vector<Part> parts, std::chrono::duration<double> lead) {
  for (const Part& part : parts) {
    first_ = std::min(first_, part.drive.first_scan());
    last_ = std::max(last_, part.drive.scans.back().time);
  }
  begin_ = MachineClock::now() + std::chrono::duration_cast<MachineClock::duration>(lead);
  PulseProgram pulses;
  FrameProgram frames;
  for (Part& part : parts) node_.push_back(prepare(vehicle, std::move(part), pulses, frames));
  const Timetable timetable{begin_, first_};
  if (auto levels = pulses.take(); !levels.empty()) {
    pulses_wanted_ = levels.size();
    pulses_.emplace(std::move(levels), timetable);
  }
  if (auto all = frames.take(); !all.empty()) {
    frames_wanted_ = all.size();
    frames_.emplace(std::move(all), frames.interfaces(), timetable);
  }
  boards_.emplace(std::move(bench_));
  for (std::size_t k = 0; k < node_.size(); ++k) boards_->plug(k);
}

Player::Node Player::prepare(const VehicleConfig& vehicle, Part part, PulseProgram& pulses,
                             FrameProgram& frames) {
  const NodeConfig& node = part.node;
  const std::string serial = serial_of(node);
  check_playable(vehicle, node, part.drive);
  if (!node.wiring.line.empty()) check_chip(node);
  PulseProgram capture;
  for (std::uint8_t line = 0; line < kEncoderLines; ++line) {
    const LineConfig* const gpio = node.wiring.line_at(line);
    const auto wire = static_cast<std::uint16_t>(2 * line);
    if (!gpio)
      capture.add(part.drive, line, wire, static_cast<std::uint16_t>(wire + 1));
    else
      pulses.add(part.drive, line, static_cast<std::uint16_t>(gpio->tooth_gpio),
                 gpio->zero_mark_gpio ? std::optional(static_cast<std::uint16_t>(*gpio->zero_mark_gpio))
                                      : std::nullopt);
  }
  frames.add(vehicle, node, part.drive);
  Node prepared{node.name, static_cast<std::int64_t>(part.drive.scans.size()), part.drive.converter_ppm,
                nullptr};
  const Timetable timetable{begin_, first_};
  prepared.player = std::make_unique<BoardPlayer>(std::move(part.drive), capture.take(), timetable);
  bench_.push_back(prepared.player->bench(serial));
  return prepared;
}

void Player::run(std::stop_token stop) {
  Parallel all;
  const std::stop_callback stopped(stop, [&] { all.request_stop(); });
  if (pulses_) all.run([this](std::stop_token token) { pulses_->run(token); });
  if (frames_) all.run([this](std::stop_token token) { frames_->run(token); });
  all.wait();
  // Packets with the last scans are on their way for some milliseconds.
  const MachineTime over = begin_ + (last_ - first_) + std::chrono::milliseconds(100);
  pause(stop, over - MachineClock::now());
}

std::string Player::report() const {
  auto nodes = nlohmann::ordered_json::array();
  for (const Node& node : node_)
    nodes.push_back({{"name", node.name},
                     {"scans", node.scans},
                     {"scans_played", node.player->played()},
                     {"board_ppm", node.converter_ppm}});
  nlohmann::ordered_json report{{"begin_ns", to_ns(begin_)}, {"first_ns", to_ns(first_)}, {"nodes", nodes}};
  if (pulses_) report["levels"] = json_of(pulses_->lateness());
  if (frames_) report["frames"] = json_of(frames_->lateness());
  return report.dump();
}

std::string Player::shortfall() const {
  for (const Node& node : node_)
    if (node.player->played() < node.scans)
      return "node " + node.name + ": " + std::to_string(node.player->played()) + " of " +
             std::to_string(node.scans) +
             " scans were converted: its board was not started in time, or stopped";
  if (pulses_ && static_cast<std::size_t>(pulses_->lateness().count) < pulses_wanted_)
    return "only " + std::to_string(pulses_->lateness().count) + " of " + std::to_string(pulses_wanted_) +
           " levels were played";
  if (frames_ && static_cast<std::size_t>(frames_->lateness().count) < frames_wanted_)
    return "only " + std::to_string(frames_->lateness().count) + " of " + std::to_string(frames_wanted_) +
           " frames were sent";
  return "";
}

}  // namespace roadbalance::test

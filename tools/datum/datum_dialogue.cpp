#include "tools/datum/datum_dialogue.hpp"

#include <cstdio>
#include <numbers>

#include "common/text/format.hpp"
#include "tools/views/wheel_angle.hpp"

namespace roadbalance {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

}  // namespace

DatumDialogue::DatumDialogue(const WheelConfig& wheel, int wanted)
    : name_(wheel.name), left_(wheel.name.ends_with("_left")), wanted_(wanted), readings_(wheel.encoder) {}

std::string DatumDialogue::greeting() const {
  return format(
      "%s: turn it forward by hand%s until its zero mark fires; let it stand. Then say where its reference "
      "point (the valve) stands: the clock as seen from outside (10:30), or degrees from the top in the "
      "direction of forward rotation (45). \"undo\" takes the last answer back.",
      name_.c_str(),
      left_ ? " (seen from outside against the clock)" : " (seen from outside with the clock)");
}

std::string DatumDialogue::where_to_turn() const {
  return format("%zu of %d. Turn it forward until the mark fires", readings_.readings() + 1, wanted_);
}

std::string DatumDialogue::take(const Edge& edge, WallTime now) {
  still_since_ = now;
  readings_.add(edge);
  if (answer_rad_) {
    answer_rad_.reset();
    return "the wheel still turns: let it stand and say again where the reference point is";
  }
  if (edge.kind == EdgeKind::kLost) return "some edges were lost: turn it on until the mark fires again";
  if (edge.kind == EdgeKind::kZeroMark && readings_.can_read())
    return "zero mark: let it stand. Where is the reference point?";
  return {};
}

std::string DatumDialogue::answer(const std::string& line, WallTime now) {
  if (line == "undo") {
    answer_rad_.reset();
    readings_.undo();
    return where_to_turn();
  }
  const auto angle_rad = parse_wheel_angle(line, left_);
  if (!angle_rad)
    return "\"" + line + "\" is no place on a wheel; allowed: 10:30, 45° (not 10: hour or degrees?), undo";
  if (!readings_.can_read()) return "the zero mark has not fired yet: turn the wheel forward until it does";
  answer_rad_ = angle_rad;
  still_since_ = std::max(still_since_, now);
  return {};
}

std::string DatumDialogue::tick(WallTime now) {
  if (!answer_rad_ || now - still_since_ < kStill) return {};
  const double read_rad = *answer_rad_;
  answer_rad_.reset();
  const double datum_rad = readings_.read(read_rad);
  std::string said = format("%.1f deg (%s): datum %.1f deg", read_rad * kDegrees,
                            clock_of(read_rad, left_).c_str(), datum_rad * kDegrees);
  return done() ? said : said + ". " + where_to_turn();
}

}  // namespace roadbalance

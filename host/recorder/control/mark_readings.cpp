#include "host/recorder/control/mark_readings.hpp"

#include <cmath>
#include <utility>

#include "common/config/section.hpp"
#include "common/text/format.hpp"
#include "common/types/angle_units.hpp"
#include "host/recorder/control/session_answers.hpp"

namespace roadbalance {
namespace {

Answer refused(Answer answer, RefusalReason reason, std::string why) {
  answer.state = AnswerState::kRefused;
  answer.reason = reason;
  answer.text = std::move(why);
  return answer;
}

Answer done_with(Answer answer, std::string text) {
  answer.state = AnswerState::kDone;
  answer.text = std::move(text);
  return answer;
}

}  // namespace

const WheelConfig& wheel_with_mark(const VehicleConfig& vehicle, int place) {
  if (place < 0 || place >= kWheels) throw ConfigError("a zero mark is of a wheel, 0 to 3");
  const WheelConfig& wheel = vehicle.wheel[static_cast<std::size_t>(place)];
  if (wheel.node.empty() || !wheel.encoder.zero_mark)
    throw ConfigError(wheel.name + " has no encoder with a zero mark");
  return wheel;
}

void MarkReadings::take(const SealedBlock& block, WallTime now) {
  if (!wheel_) return;
  wheel_->line.take(block);
  if (block.header.node == wheel_->node_id) wheel_->heard = now;
  for (; !wheel_->line.edges.empty(); wheel_->line.edges.pop_front()) {
    wheel_->readings.add(wheel_->line.edges.front());
    wheel_->still_since = now;
  }
}

Answer MarkReadings::take(const Request& request, const VehicleConfig& vehicle, WallTime now) {
  Answer answer = answer_to(request, 0);
  answer.value = {};
  try {
    if (request.value[1] == 0.0) return begin(answer, vehicle, request.channel, now);
    (void)wheel_with_mark(vehicle, request.channel);
  } catch (const ConfigError& error) {
    return refused(answer, RefusalReason::kBadArgument, error.what());
  }
  if (!wheel_ || wheel_->place != request.channel)
    return refused(answer, RefusalReason::kBadArgument, "begin with this wheel first");
  if (!(std::abs(request.value[0]) <= kTurn))
    return refused(answer, RefusalReason::kBadArgument, "an angle is at most a turn");
  return read(answer, request.value[0], now);
}

Answer MarkReadings::begin(Answer answer, const VehicleConfig& vehicle, int place, WallTime now) {
  const WheelConfig& wheel = wheel_with_mark(vehicle, place);
  const NodeConfig& node = vehicle.node_named(wheel.node);
  wheel_.emplace(Wheel{.place = place,
                       .name = wheel.name,
                       .node = node.name,
                       .line = LineEdges(node.id, wheel.line),
                       .readings = DatumReadings(wheel.encoder),
                       .node_id = node.id,
                       .still_since = now,
                       .heard = now});
  return done_with(
      answer, wheel.name + ": turn it forward by hand until its zero mark fires, let it stand, and read " +
                  "where its reference point (the valve) is");
}

Answer MarkReadings::read(Answer answer, double angle_rad, WallTime now) {
  DatumReadings& readings = wheel_->readings;
  const auto refuse = [&](RefusalReason reason, std::string why) {
    return refused(answer, reason, wheel_->name + ": " + std::move(why));
  };
  if (!wheel_->line.heard_blocks())
    return refuse(RefusalReason::kNoAnswer,
                  "nothing has come from node " + wheel_->node + " yet: is it recorded?");
  // A wheel of which nothing is heard may turn: what stands was heard to stand.
  if (now - wheel_->heard >= kStill)
    return refuse(RefusalReason::kNoAnswer, "nothing comes from node " + wheel_->node + " any more");
  if (wheel_->heard - wheel_->still_since < kStill)
    return refuse(RefusalReason::kMoving,
                  "it turns, or has just come to a stand: wait a second, then read again");
  if (!readings.can_read())
    return refuse(RefusalReason::kMoving,
                  "its zero mark has not fired since, or edges were lost: turn it forward until it fires");
  if (readings.readings() >= kMost)
    return refuse(RefusalReason::kBadArgument, "that is enough: set the datum");
  const double one_rad = readings.read(angle_rad);
  if (const std::string objection = readings.objection(); !objection.empty()) {
    const bool are_two = readings.readings() == 2;  // and either may be wrong
    readings.undo();
    if (are_two) readings.undo();
    return refuse(RefusalReason::kBadArgument,
                  objection + (are_two ? " Neither of the two counts: turn it on, and read both again."
                                       : " This reading does not count."));
  }
  const auto datum = readings.datum();
  if (!datum)
    return done_with(answer,
                     format("%s: the first reading says %.1f deg. Turn it forward until its mark fires again",
                            wheel_->name.c_str(), one_rad * kDegrees));
  answer.value = {datum->datum_rad, datum->sigma_rad};
  return done_with(
      answer, format("%s: %zu readings say %.1f ± %.1f deg; five are good. Turn it on, or stop the recording "
                     "and set the datum",
                     wheel_->name.c_str(), readings.readings(), datum->datum_rad * kDegrees,
                     datum->sigma_rad * kDegrees));
}

}  // namespace roadbalance

#include <cstdio>
#include <numbers>

#include "common/process/stop_on_signal.hpp"
#include "tools/rb/datum.hpp"
#include "tools/rb/datum_dialogue.hpp"
#include "tools/rb/edge_listener.hpp"
#include "tools/rb/typed_lines.hpp"

namespace roadbalance {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr std::chrono::seconds kSilence{3};

void say(const std::string& sentence) {
  if (!sentence.empty()) std::fprintf(stderr, "%s\n", sentence.c_str());
}

/// Why no edges come, once; empty: they may.
std::string why_silent(const EdgeListener& listener, const NodeConfig& node, const std::string& url) {
  if (listener.line.heard_blocks()) return {};
  if (listener.line.heard_preview())
    return "node " + node.name +
           " is there, but sends its edges only while somebody records: start rb-recorder beside it";
  return "node " + node.name + " is not heard on " + url;
}

/// True when all readings are there; false if nobody can give more.
bool lead(DatumDialogue& dialogue, EdgeListener& listener, TypedLines& lines, const DatumOptions& options,
          const NodeConfig& node, const std::stop_token& stop) {
  const WallTime begin = WallClock::now();
  bool silence_said = false;
  while (!dialogue.done() && !stop.stop_requested()) {
    listener.handle(std::chrono::milliseconds(50));
    for (const std::string& sentence : listener.other_versions()) say(sentence);
    const WallTime now = WallClock::now();
    for (; !listener.line.edges.empty(); listener.line.edges.pop_front())
      say(dialogue.take(listener.line.edges.front(), now));
    say(dialogue.tick(now));
    if (!silence_said && now - begin > kSilence) {
      silence_said = true;
      say(why_silent(listener, node, options.url));
    }
    // What comes through a pipe was written in advance and waits until it is asked for.
    if (lines.terminal() || dialogue.awaits_answer(now)) {
      if (const auto line = lines.next()) say(dialogue.answer(*line, now));
      if (lines.ended() && dialogue.awaits_answer(now)) {
        say("standard input ended");
        return false;
      }
    }
    if (options.patience_s > 0.0 && now - begin > std::chrono::duration<double>(options.patience_s))
      return false;
  }
  return dialogue.done();
}

}  // namespace

std::optional<FoundDatum> datum_by_turning(const DatumOptions& options, const WheelConfig& wheel,
                                           const NodeConfig& node) {
  const StopOnSignal signals;
  TypedLines lines(0);
  EdgeListener listener(options.url, node.id, wheel.line);
  DatumDialogue dialogue(wheel, options.readings);
  say(dialogue.greeting());
  if (!lead(dialogue, listener, lines, options, node, signals.token())) {
    std::fprintf(stderr, "rb datum: only %zu of %d readings; nothing is set\n",
                 dialogue.readings().readings(), options.readings);
    return std::nullopt;
  }
  if (const std::string objection = dialogue.objection(); !objection.empty()) {
    std::fprintf(stderr, "rb datum: %s\n", objection.c_str());
    return std::nullopt;
  }
  const auto datum = *dialogue.readings().datum();
  char sentence[160];
  std::snprintf(sentence, sizeof sentence, "from %d readings with a scatter of %.1f deg", options.readings,
                datum.scatter_rad * kDegrees);
  return FoundDatum{
      datum.datum_rad,
      datum.sigma_rad,
      {{"method", "turning"}, {"readings", options.readings}, {"scatter_deg", datum.scatter_rad * kDegrees}},
      sentence};
}

}  // namespace roadbalance
